// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/network/inference.hpp"

#include <fmt/format.h>

#include <opencv2/dnn.hpp>

namespace edvo {
namespace {

// The innermost message: OpenCV wraps one error in the next, line by line.
std::string reason_of(const cv::Exception& error) {
  const std::string& text = error.err;
  const std::size_t last = text.rfind("error: ");
  std::string reason = last == std::string::npos ? text : text.substr(last + 7);
  return reason.substr(0, reason.find('\n'));
}

class OpenCvInference final : public Inference {
 public:
  OpenCvInference(const std::string& onnx, std::string output) try
      : output_(std::move(output)), network_(cv::dnn::readNetFromONNX(onnx.data(), onnx.size())) {
    network_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  } catch (const cv::Exception& error) {
    throw Error(ErrorCode::kModel, fmt::format("OpenCV {} cannot load this network: {}", CV_VERSION,
                                               reason_of(error)));
  }

  [[nodiscard]] cv::Mat forward(const cv::Mat_<cv::Vec3f>& image) override try {
    network_.setInput(cv::dnn::blobFromImage(image));
    return network_.forward(output_).clone();
  } catch (const cv::Exception& error) {
    throw Error(ErrorCode::kModel,
                fmt::format("OpenCV {} cannot run this network on an image of {} x {} px: {}",
                            CV_VERSION, image.cols, image.rows, reason_of(error)));
  }

 private:
  std::string output_;
  cv::dnn::Net network_;
};

}  // namespace

std::unique_ptr<Inference> make_opencv_inference(const std::string& onnx,
                                                 const std::string& output) {
  return std::make_unique<OpenCvInference>(onnx, output);
}

}  // namespace edvo
