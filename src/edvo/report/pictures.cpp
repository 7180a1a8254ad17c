// SPDX-License-Identifier: MIT
#include "edvo/report/pictures.hpp"

#include "edvo/io/jpeg.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace edvo {
namespace {

constexpr std::size_t kMostLosses = 5;
constexpr std::size_t kMostStretches = 64;  // even
constexpr int kQuality = 75;                // about 12 KB a picture

cv::Mat shrunk(const cv::Mat& image) {
  if (image.cols <= kPictureWidth) return image;
  cv::Mat small;
  const int height = std::max(1, image.rows * kPictureWidth / image.cols);
  cv::resize(image, small, {kPictureWidth, height}, 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace

void PictureCandidates::offer(const FrameResult& result, const cv::Mat& bgr) {
  if (bgr.empty()) return;
  if (result.status == FrameStatus::kLost) {
    offer_lost(result.index, bgr);
    return;
  }
  was_lost_ = false;
  // Those that nothing was aligned to have no residuals, and those of NaN say nothing.
  if (stretch_.frame < 0 || result.rms > stretch_.rms)
    stretch_ = {.frame = result.index, .rms = result.rms, .image = bgr};
  if (++in_stretch_ >= per_stretch_) close_stretch();
}

void PictureCandidates::offer_lost(std::int64_t frame, const cv::Mat& bgr) {
  if (!was_lost_) {
    if (losses_.size() > kMostLosses)
      losses_.erase(std::ranges::min_element(losses_, {}, &Candidate::lost_frames));
    losses_.push_back({.frame = frame, .image = shrunk(bgr)});
  }
  ++losses_.back().lost_frames;
  was_lost_ = true;
}

void PictureCandidates::close_stretch() {
  stretch_.image = shrunk(stretch_.image);
  stretches_.push_back(std::exchange(stretch_, {}));
  in_stretch_ = 0;
  if (stretches_.size() < kMostStretches) return;
  for (std::size_t i = 0; i < kMostStretches / 2; ++i) {
    Candidate& first = stretches_[2 * i];
    Candidate& second = stretches_[2 * i + 1];
    stretches_[i] = second.rms > first.rms ? std::move(second) : std::move(first);
  }
  stretches_.resize(kMostStretches / 2);
  per_stretch_ *= 2;
}

std::vector<PictureCandidates::Candidate> PictureCandidates::all() const {
  std::vector<Candidate> candidates = losses_;
  candidates.insert(candidates.end(), stretches_.begin(), stretches_.end());
  if (stretch_.frame >= 0) candidates.push_back(stretch_);
  return candidates;
}

std::vector<std::int64_t> PictureCandidates::frames() const {
  std::vector<std::int64_t> frames;
  for (const Candidate& candidate : all()) frames.push_back(candidate.frame);
  std::ranges::sort(frames);
  return frames;
}

std::string PictureCandidates::jpeg_of(std::int64_t frame) const {
  for (const Candidate& candidate : all())
    if (candidate.frame == frame) return encode_jpeg(shrunk(candidate.image), kQuality);
  return "";
}

}  // namespace edvo
