// SPDX-License-Identifier: MIT
#include "edvo/features/edge_strength.hpp"

#include <opencv2/imgproc.hpp>
#include <utility>

namespace edvo {
namespace {

class StrengthDetector final : public EdgeDetector {
 public:
  StrengthDetector(std::unique_ptr<EdgeStrength> source, NetworkOptions options)
      : source_(std::move(source)), options_(std::move(options)) {}

  [[nodiscard]] cv::Mat_<std::uint8_t> detect(const EdgeInput& image) const override {
    return edges_of_strength(source_->strength(image.colour()), image.gray, options_);
  }

 private:
  std::unique_ptr<EdgeStrength> source_;
  NetworkOptions options_;
};

}  // namespace

cv::Mat_<std::uint8_t> edges_of_strength(const cv::Mat_<float>& strength,
                                         const cv::Mat_<std::uint8_t>& gray,
                                         const NetworkOptions& options) {
  // A network's line may lie a pixel beside the step of the image.
  cv::Mat_<float> weights;
  cv::dilate(strength, weights, cv::Mat::ones(3, 3, CV_8U));
  cv::pow(weights, options.edge_exponent, weights);
  return canny_edges(gray, options.canny, weights);
}

std::unique_ptr<EdgeDetector> make_strength_detector(std::unique_ptr<EdgeStrength> source,
                                                     const NetworkOptions& options) {
  return std::make_unique<StrengthDetector>(std::move(source), options);
}

}  // namespace edvo
