// SPDX-License-Identifier: MIT
#include "edvo/features/edge_detector.hpp"

namespace edvo {
namespace {

class CannyDetector final : public EdgeDetector {
 public:
  explicit CannyDetector(const CannyOptions& options) : options_(options) {}

  [[nodiscard]] cv::Mat_<std::uint8_t> detect(const EdgeInput& image) const override {
    return canny_edges(image.gray, options_);
  }

 private:
  CannyOptions options_;
};

class DenseDetector final : public EdgeDetector {
 public:
  [[nodiscard]] cv::Mat_<std::uint8_t> detect(const EdgeInput& image) const override {
    return cv::Mat_<std::uint8_t>(image.gray.size(), std::uint8_t{255});
  }
};

}  // namespace

std::unique_ptr<EdgeDetector> make_canny_detector(const CannyOptions& options) {
  return std::make_unique<CannyDetector>(options);
}

std::unique_ptr<EdgeDetector> make_dense_detector() {
  return std::make_unique<DenseDetector>();
}

}  // namespace edvo
