// SPDX-License-Identifier: MIT
#include "edvo/source/masked_source.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/image_file.hpp"

#include <fmt/core.h>

#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace edvo {
namespace {

void require_usable(const cv::Mat_<std::uint8_t>& mask, cv::Size size, const std::string& name) {
  if (mask.size() != size)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: the mask has {} x {} px, the images {} x {}", name, mask.cols,
                            mask.rows, size.width, size.height));
  if (cv::countNonZero(mask) == 0)
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: the mask hides everything; what is to be seen must be white", name));
}

}  // namespace

cv::Mat_<std::uint8_t> read_mask(const std::filesystem::path& file, cv::Size size) {
  cv::Mat_<std::uint8_t> mask;
  cv::cvtColor(read_colour(file), mask, cv::COLOR_BGR2GRAY);
  cv::threshold(mask, mask, 127, 255, cv::THRESH_BINARY);
  require_usable(mask, size, file.string());
  return mask;
}

MaskedSource::MaskedSource(std::unique_ptr<RgbdSource> source, const cv::Mat_<std::uint8_t>& mask,
                           const std::string& name)
    : source_(std::move(source)), info_(source_->info()) {
  require_usable(mask, {info_.camera.pinhole.width, info_.camera.pinhole.height}, name);
  hidden_ = mask == 0;
  info_.notes.push_back(
      fmt::format("{} hides {:.1f} % of the image", name,
                  100.0 * cv::countNonZero(hidden_) / static_cast<double>(hidden_.total())));
}

std::optional<PendingFrame> MaskedSource::next() {
  std::optional<PendingFrame> frame = source_->next();
  if (!frame) return frame;
  frame->load = [load = std::move(frame->load), hidden = hidden_] {
    RgbdImage image = load();
    // An image of another size is for the tracker to refuse.
    if (image.depth.size() == hidden.size())
      image.depth.setTo(std::numeric_limits<float>::quiet_NaN(), hidden);
    return image;
  };
  return frame;
}

}  // namespace edvo
