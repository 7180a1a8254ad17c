// SPDX-License-Identifier: MIT
// What run() needs of a pose estimator: the members of Odometry that it calls.
#pragma once

#include "edvo/odometry/odometry.hpp"
#include "edvo/slam/relocalizer.hpp"

#include <vector>

namespace edvo {

// See Odometry for what each member does.
class Tracker {
 public:
  virtual ~Tracker() = default;
  [[nodiscard]] virtual PreparedImage prepare(const RgbdImage& image) const = 0;  // any thread
  virtual FrameResult process(const PreparedImage& image) = 0;
  virtual void finish(int threads) = 0;
  [[nodiscard]] virtual Trajectory trajectory() const = 0;
  [[nodiscard]] virtual Trajectory keyframe_trajectory() const = 0;
  [[nodiscard]] virtual const Map& map() const = 0;
  [[nodiscard]] virtual KeyframePtr newest_keyframe() const = 0;
  // Of Slam; an odometry knows its own frames only.
  [[nodiscard]] virtual MapFrame map_frame(int segment) const = 0;
  // Of Slam; an odometry looks for none.
  [[nodiscard]] virtual std::vector<LinkReport> links() const = 0;
};

// Wraps any class that has these members.
template <typename T>
class TrackerOf final : public Tracker {
 public:
  explicit TrackerOf(T& tracker) : tracker_(tracker) {}
  [[nodiscard]] PreparedImage prepare(const RgbdImage& image) const override {
    return tracker_.prepare(image);
  }
  FrameResult process(const PreparedImage& image) override { return tracker_.process(image); }
  void finish(int threads) override { tracker_.finish(threads); }
  [[nodiscard]] Trajectory trajectory() const override { return tracker_.trajectory(); }
  [[nodiscard]] Trajectory keyframe_trajectory() const override {
    return tracker_.keyframe_trajectory();
  }
  [[nodiscard]] const Map& map() const override { return tracker_.map(); }
  [[nodiscard]] KeyframePtr newest_keyframe() const override { return tracker_.newest_keyframe(); }
  [[nodiscard]] MapFrame map_frame(int segment) const override {
    if constexpr (requires { tracker_.map_frame(segment); })
      return tracker_.map_frame(segment);
    else
      return {.segment = segment, .map_from_odometry = {}};
  }
  [[nodiscard]] std::vector<LinkReport> links() const override {
    if constexpr (requires { tracker_.links(); })
      return tracker_.links();
    else
      return {};
  }

 private:
  T& tracker_;
};

}  // namespace edvo
