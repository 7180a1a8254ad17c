// SPDX-License-Identifier: MIT
#include "edvo/network/edge_network.hpp"

#include "edvo/core/did_you_mean.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/model_file.hpp"
#include "edvo/network/inference.hpp"
#include "edvo/network/onnx_graph.hpp"
#include "edvo/network/onnx_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

// Probabilities may leave [0..1] by rounding; more means that an activation is missing.
constexpr double kProbabilityTolerance = 1e-3;

[[noreturn]] void fail(const std::string& source, const std::string& reason) {
  throw Error(ErrorCode::kModel, fmt::format("{}: {}", source, reason));
}

std::vector<std::string> outputs_of(const Model& model) {
  try {
    return onnx_outputs(model.weights);
  } catch (const Error& error) {
    fail(model.source, error.what());
  }
}

std::string output_name(const Model& model) {
  const std::vector<std::string> names = outputs_of(model);
  const NetworkOutput& wanted = model.description.output;
  if (!wanted.name.empty()) {
    if (std::ranges::find(names, wanted.name) == names.end())
      fail(model.source, fmt::format("it has no output '{}'{}; its outputs are {}", wanted.name,
                                     did_you_mean(wanted.name, names), fmt::join(names, ", ")));
    return wanted.name;
  }
  const int count = static_cast<int>(names.size());
  if (wanted.index >= count)
    fail(model.source, fmt::format("output.index {} is out of range; its outputs are, from 0: {}",
                                   wanted.index, fmt::join(names, ", ")));
  return wanted.index < 0 ? names.back() : names[static_cast<std::size_t>(wanted.index)];
}

std::string spelled(cv::Size size) {
  return fmt::format("{} x {}", size.width, size.height);
}

// The image as the network wants it.
struct Fitted {
  cv::Mat image;
  cv::Size content;  // [px], without padding
};

// The size of an image of this size for the network, before its sides become multiples of the
// stride.
cv::Size content_size(cv::Size image, const NetworkInput& rule, const std::string& source) {
  cv::Size content = rule.size;
  if (content.empty())
    content = {cvRound(image.width * rule.factor), cvRound(image.height * rule.factor)};
  if (std::min(content.width, content.height) < rule.multiple_of)
    fail(source, fmt::format("an image of {} px is too small for this network, whose stride is {} "
                             "px (input.multiple_of)",
                             spelled(content), rule.multiple_of));
  return content;
}

cv::Size padded(cv::Size content, const NetworkInput& rule) {
  const auto multiple = [n = rule.multiple_of](int side) { return (side + n - 1) / n * n; };
  return {multiple(content.width), multiple(content.height)};
}

Fitted fit(const cv::Mat& bgr, const NetworkInput& rule, const std::string& source) {
  Fitted fitted{.image = bgr, .content = content_size(bgr.size(), rule, source)};
  if (fitted.content != bgr.size()) {
    const bool shrinks = fitted.content.area() < bgr.size().area();
    cv::resize(bgr, fitted.image, fitted.content, 0, 0,
               shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  }
  const cv::Size size = padded(fitted.content, rule);
  const int right = size.width - fitted.content.width;
  const int below = size.height - fitted.content.height;
  if (right > 0 || below > 0)
    cv::copyMakeBorder(
        cv::Mat(fitted.image), fitted.image, 0, below, 0, right,
        rule.padding == Padding::kReflect ? cv::BORDER_REFLECT_101 : cv::BORDER_REPLICATE);
  return fitted;
}

// A maximum or a clip inside the network may hide NaN weights from its output.
void check_weights(const OnnxGraph& graph) {
  for (const auto& [name, tensor] : graph.constants) {
    if (tensor.type != OnnxType::kFloat) continue;
    const std::vector<float> numbers = floats_of(tensor);
    if (!std::ranges::all_of(numbers, [](float number) { return std::isfinite(number); }))
      throw Error(ErrorCode::kModel, fmt::format("the weights '{}' are not all finite", name));
  }
}

std::unique_ptr<Inference> load(const Model& model, const std::string& output,
                                InferenceEngine engine, cv::Size size) {
  const std::optional<std::string> plain = with_plain_weights(model.weights, model.source);
  const std::string& onnx = plain ? *plain : model.weights;
  try {
    OnnxGraph graph = onnx_graph(onnx);
    check_weights(graph);
    if (engine == InferenceEngine::kOpenCv) return make_opencv_inference(onnx, output);
    try {
      return make_onednn_inference(std::move(graph), output, size);
    } catch (const Error&) {
      // OpenCV knows more operators, and says what is wrong if it does not know these either.
      if (engine == InferenceEngine::kOneDnn) throw;
      return make_opencv_inference(onnx, output);
    }
  } catch (const Error& error) {
    fail(model.source, error.what());
  }
}

class NetworkStrength final : public EdgeStrength {
 public:
  NetworkStrength(const Model& model, InferenceEngine engine, cv::Size image_size)
      : description_(model.description),
        source_(model.source),
        output_(output_name(model)),
        inference_(load(
            model, output_, engine,
            padded(content_size(image_size, description_.input, source_), description_.input))) {}

  [[nodiscard]] cv::Mat_<float> strength(const cv::Mat_<cv::Vec3b>& bgr) const override {
    const Fitted fitted = fit(bgr, description_.input, source_);
    cv::Mat_<float> map = run(fitted.image);
    activate(map);
    if (fitted.content != map.size()) map = map(cv::Rect({}, fitted.content)).clone();
    if (fitted.content != bgr.size()) {
      cv::Mat resized;
      cv::resize(map, resized, bgr.size(), 0, 0, cv::INTER_LINEAR);
      map = resized;
    }
    return map;
  }

 private:
  // The network's output for a fitted image: as large as that, finite.
  cv::Mat_<float> run(const cv::Mat& image) const {
    const cv::Mat output = forward(normalized(image));
    const bool is_plane = output.dims >= 2 && output.type() == CV_32FC1 &&
                          output.size[output.dims - 2] == image.rows &&
                          output.size[output.dims - 1] == image.cols &&
                          output.total() == image.total();
    if (!is_plane)
      fail(source_,
           fmt::format("output '{}' has the shape {}; for an image of {} px an edge map "
                       "of 1 x 1 x {} x {} is expected",
                       output_, shape_of(output), spelled(image.size()), image.rows, image.cols));
    cv::Mat_<float> plane = output.reshape(1, image.rows);
    if (!cv::checkRange(plane))
      fail(source_, fmt::format("output '{}' is not finite everywhere", output_));
    return plane;
  }

  cv::Mat_<cv::Vec3f> normalized(const cv::Mat& bgr) const {
    const NetworkInput& input = description_.input;
    cv::Mat channels = bgr;
    if (input.channels == ChannelOrder::kRgb) cv::cvtColor(bgr, channels, cv::COLOR_BGR2RGB);
    cv::Mat_<cv::Vec3f> image;
    cv::subtract(channels, cv::Scalar(input.mean[0], input.mean[1], input.mean[2]), image,
                 cv::noArray(), CV_32F);
    if (input.scale != 1) image.convertTo(image, CV_32F, input.scale);
    return image;
  }

  cv::Mat forward(const cv::Mat_<cv::Vec3f>& image) const {
    const std::scoped_lock lock(mutex_);
    try {
      return inference_->forward(image);
    } catch (const Error& error) {
      fail(source_, error.what());
    }
  }

  void activate(cv::Mat_<float>& strength) const {
    if (description_.output.activation == Activation::kSigmoid) {
      cv::exp(-strength, strength);
      strength = 1 / (1 + strength);
      return;
    }
    double lowest = 0, highest = 0;
    cv::minMaxLoc(strength, &lowest, &highest);
    if (lowest < -kProbabilityTolerance || highest > 1 + kProbabilityTolerance)
      fail(source_,
           fmt::format("output '{}' goes from {:.3g} to {:.3g} instead of 0 to 1; does its "
                       "description lack activation = \"sigmoid\"?",
                       output_, lowest, highest));
    for (float& value : strength) value = std::clamp(value, 0.F, 1.F);
  }

  static std::string shape_of(const cv::Mat& output) {
    return fmt::format("{}", fmt::join(output.size.p, output.size.p + output.dims, " x "));
  }

  ModelDescription description_;
  std::string source_;  // the ONNX file, for messages
  std::string output_;
  mutable std::mutex mutex_;  // a forward pass writes into the network's memory
  std::unique_ptr<Inference> inference_;
};

Model model_of(const NetworkOptions& options) {
  return options.model.empty() ? own_model() : read_model(options.model);
}

}  // namespace

std::unique_ptr<EdgeStrength> make_network_strength(const Model& model, cv::Size image_size,
                                                    InferenceEngine engine) {
  auto network = std::make_unique<NetworkStrength>(model, engine, image_size);
  (void)network->strength(cv::Mat_<cv::Vec3b>(image_size, cv::Vec3b(0, 0, 0)));
  return network;
}

std::unique_ptr<EdgeStrength> open_network(const NetworkOptions& options, cv::Size image_size) {
  return make_network_strength(model_of(options), image_size);
}

std::unique_ptr<EdgeStrength> open_cached_network(const NetworkOptions& options,
                                                  cv::Size image_size, EdgeCache cache) {
  const Model model = model_of(options);
  return make_cached_strength(make_network_strength(model, image_size), fingerprint(model),
                              std::move(cache));
}

std::string fingerprint(const Model& model) {
  const auto& [name, file, hash, licence, source, input, output] = model.description;
  // A hash that stands in the description was checked when the weights were read.
  return sha256(fmt::format(
      "{} {} {} {} {} {} {}x{} {} {} {} {} OpenCV {} oneDNN {}",
      hash.empty() ? sha256(model.weights) : hash, static_cast<int>(input.channels),
      fmt::join(input.mean, " "), input.scale, input.multiple_of, static_cast<int>(input.padding),
      input.size.width, input.size.height, input.factor, output.name, output.index,
      static_cast<int>(output.activation), CV_VERSION, onednn_version()));
}

}  // namespace edvo
