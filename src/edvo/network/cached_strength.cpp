// SPDX-License-Identifier: MIT
#include "edvo/network/cached_strength.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/strength_file.hpp"

#include <fmt/core.h>

#include <optional>
#include <string_view>
#include <utility>

namespace edvo {
namespace {

class CachedStrength final : public EdgeStrength {
 public:
  CachedStrength(std::unique_ptr<EdgeStrength> source, std::string fingerprint, EdgeCache cache)
      : source_(std::move(source)),
        fingerprint_(std::move(fingerprint)),
        cache_(std::move(cache)) {}

  [[nodiscard]] cv::Mat_<float> strength(const cv::Mat_<cv::Vec3b>& bgr) const override {
    const std::string file = fmt::format("{}/{}.edges", cache_.folder, key_of(bgr));
    if (const std::optional<cv::Mat_<float>> known = find(file, bgr.size())) return *known;
    const cv::Mat_<float> map = source_->strength(bgr);
    try {
      write_strength(file, map);
    } catch (const Error& error) {
      cache_.warn(error.what());
    }
    return map;
  }

 private:
  [[nodiscard]] std::string key_of(const cv::Mat_<cv::Vec3b>& bgr) const {
    const cv::Mat_<cv::Vec3b> whole = bgr.isContinuous() ? bgr : bgr.clone();
    const std::string_view pixels(reinterpret_cast<const char*>(whole.data),
                                  whole.total() * whole.elemSize());
    return sha256(fmt::format("{} {}x{} {}", fingerprint_, bgr.cols, bgr.rows, sha256(pixels)));
  }

  [[nodiscard]] std::optional<cv::Mat_<float>> find(const std::string& file, cv::Size size) const {
    try {
      std::optional<cv::Mat_<float>> known = find_strength(file);
      if (!known || known->size() == size) return known;
      cache_.warn(file + ": an edge map of another size; computed again");
    } catch (const Error& error) {
      cache_.warn(fmt::format("{}; computed again", error.what()));
    }
    return std::nullopt;
  }

  std::unique_ptr<EdgeStrength> source_;
  std::string fingerprint_;
  EdgeCache cache_;
};

}  // namespace

std::unique_ptr<EdgeStrength> make_cached_strength(std::unique_ptr<EdgeStrength> source,
                                                   std::string fingerprint, EdgeCache cache) {
  return std::make_unique<CachedStrength>(std::move(source), std::move(fingerprint),
                                          std::move(cache));
}

}  // namespace edvo
