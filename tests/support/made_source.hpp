// SPDX-License-Identifier: MIT
// Sources of frames that a test makes up.
#pragma once

#include "edvo/core/error.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

namespace edvo::test {

// Frames 0 to count - 1, 0.1 s apart. After them the source ends, or throws the error.
class MadeSource : public RgbdSource {
 public:
  using Make = std::function<RgbdImage(std::int64_t)>;

  MadeSource(std::int64_t count, Make make) : count_(count), make_(std::move(make)) {
    info_.name = "made";
    info_.origin = "made by a test";
    info_.frames = count;
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] SourceInfo& info() { return info_; }

  [[nodiscard]] std::optional<PendingFrame> next() override {
    if (next_ < count_) {
      const std::int64_t i = next_++;
      return PendingFrame{.index = i,
                          .stamp = {.nanoseconds = 100'000'000 * i, .decimals = 1},
                          .load = [this, i] { return make_(i); }};
    }
    if (error) throw Error(*error);
    return std::nullopt;
  }

  std::optional<Error> error;  // ends it

 private:
  SourceInfo info_;
  std::int64_t count_, next_ = 0;
  Make make_;
};

// A camera: its next() waits until the test lets a frame come.
class FakeLiveSource final : public RgbdSource {
 public:
  explicit FakeLiveSource(MadeSource::Make make) : make_(std::move(make)) {
    info_.name = "camera";
    info_.origin = "made by a test";
    info_.is_live = true;
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  [[nodiscard]] SourceInfo& info() { return info_; }

  // A frame comes.
  void deliver() {
    const std::lock_guard lock(mutex_);
    ++come_;
    changed_.notify_all();
  }

  // Until all that have come are taken.
  void wait_until_taken() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_ && taken_ == come_; });
  }

  [[nodiscard]] std::optional<PendingFrame> next() override {
    std::unique_lock lock(mutex_);
    waiting_ = true;
    changed_.notify_all();
    changed_.wait(lock, [&] { return taken_ < come_ || stopped_; });
    waiting_ = false;
    if (taken_ == come_) return std::nullopt;
    const std::int64_t i = taken_++;
    return PendingFrame{.index = i,
                        .stamp = {.nanoseconds = 100'000'000 * i, .decimals = 1},
                        .load = [this, i] { return make_(i); }};
  }

  void stop() override {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

 private:
  SourceInfo info_;
  MadeSource::Make make_;
  std::mutex mutex_;  // of all that follows
  std::condition_variable changed_;
  std::int64_t come_ = 0, taken_ = 0;
  bool waiting_ = false, stopped_ = false;
};

}  // namespace edvo::test
