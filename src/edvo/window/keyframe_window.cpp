// SPDX-License-Identifier: MIT
#include "edvo/window/keyframe_window.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace edvo {
namespace {

constexpr double kSameView = 0.3;  // [0..1] of a keyframe's points that an anchor must see
// Frames share a keyframe's cost: steps of the refinement in the first of them, which also pays for
// its linearization, and in each of the next.
constexpr int kStepsAtFirst = 2, kSteps = 3;

}  // namespace

void KeyframeWindow::add(std::int64_t id, const Frame& frame, const SE3& world_from_camera,
                         const Alignment& from_last, const std::vector<SelectedPixel>& pixels,
                         const WindowOptions& options) {
  if (options.keyframes == 0) return;
  WindowKeyframe key = make_window_keyframe(frame, world_from_camera, pixels, options);
  key.id = id;
  if (!recent_.empty()) {  // I = gain * radiance + bias, chained over the last keyframe
    key.gain = from_last.gain * recent_.back().gain;
    key.bias = from_last.gain * recent_.back().bias + from_last.bias;
  }
  recent_.push_back(std::move(key));
  const auto limit = static_cast<std::size_t>(options.keyframes + options.candidate_keyframes);
  if (recent_.size() > limit) drop_one(options);
  waiting_ = true;
}

bool KeyframeWindow::refine(const Camera& camera, double readout_seconds,
                            const WindowOptions& options) {
  const bool begins = waiting_;
  waiting_ = false;
  refined_.clear();
  if (begins) {
    for (WindowKeyframe& key : recent_) key.shutter.readout_seconds = readout_seconds;
    choose_members(camera, options);
  }
  if (!begins && refinement_.finished) return false;
  std::vector<WindowKeyframe> window;
  for (const std::size_t k : members_) window.push_back(std::move(recent_[k]));
  if (begins) refinement_ = begin_refinement(window, camera, fixed_, options, pairs_);
  advance(refinement_, window, begins ? kStepsAtFirst : kSteps, pairs_);
  for (std::size_t i = 0; i < members_.size(); ++i) {
    recent_[members_[i]] = std::move(window[i]);
    const WindowKeyframe& key = recent_[members_[i]];
    refined_.push_back({.id = key.id, .world_from_camera = key.world_from_key});
  }
  return !refinement_.finished;
}

// The keyframe, not the first nor one to be refined, without which the least gap is left.
void KeyframeWindow::drop_one(const WindowOptions& options) {
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k + static_cast<std::size_t>(options.keyframes) < recent_.size(); ++k) {
    const SE3 gap = inverse(recent_[k - 1].world_from_key) * recent_[k + 1].world_from_key;
    const double size = gap.translation.norm() + rotation_angle(gap);
    if (size < least) {
      least = size;
      best = k;
    }
  }
  recent_.erase(recent_.begin() + static_cast<std::ptrdiff_t>(best));
}

// The last keyframes, and before them those older ones that see most of the newest one's points.
void KeyframeWindow::choose_members(const Camera& camera, const WindowOptions& options) {
  const std::size_t count = recent_.size();
  const std::size_t free = std::min(count, static_cast<std::size_t>(options.keyframes));
  std::vector<std::pair<double, std::size_t>>
      views;  // negated, so that sorting puts the best first
  for (std::size_t k = 0; k + free < count; ++k) {
    const double view = shared_view(recent_.back(), recent_[k], camera);
    if (view > kSameView) views.emplace_back(-view, k);
  }
  std::sort(views.begin(), views.end());
  views.resize(std::min(views.size(), static_cast<std::size_t>(options.fixed_keyframes)));
  members_.clear();
  for (const auto& [view, k] : views) members_.push_back(k);
  std::sort(members_.begin(), members_.end());
  fixed_ = std::max(1, static_cast<int>(members_.size()));
  for (std::size_t k = count - free; k < count; ++k) members_.push_back(k);
}

}  // namespace edvo
