// SPDX-License-Identifier: MIT
// Frames read, decoded and prepared ahead of who needs them.
#pragma once

#include "edvo/core/error.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace edvo {

// A frame in its place in the sequence, or why it could not be read.
template <typename Frame>
struct Prefetched {
  std::size_t index = 0;
  std::variant<Frame, Error> content;
};

struct PrefetchOptions {
  int threads = 2;  // of the whole program: 1 = read when asked, otherwise threads - 1 read ahead
  int ahead = 6;    // frames in memory at most, per reading thread
};

// Delivers frames 0 to count - 1 in order, the same for any number of threads. Who asks before a
// frame is there reads along instead of waiting, so that no thread is idle. May be destroyed at any
// time; then it waits only for reads that have begun.
template <typename Frame>
class Prefetch {
 public:
  using Read = std::function<Frame(std::size_t)>;  // called from several threads at once

  Prefetch(Read read, std::size_t count, const PrefetchOptions& options = {});

  // The next frame, empty after the last one.
  [[nodiscard]] std::optional<Prefetched<Frame>> next();

 private:
  // More would only hold more memory: tracking is slower than that.
  static constexpr int kMostReaders = 4;

  [[nodiscard]] Prefetched<Frame> read_frame(std::size_t index) const;
  [[nodiscard]] bool has_room() const;
  void read_one(std::unique_lock<std::mutex>& lock);
  void work(const std::stop_token& stop);

  Read read_;
  std::size_t count_;
  std::mutex mutex_;  // of all that follows
  std::condition_variable_any changed_;
  std::vector<std::optional<Prefetched<Frame>>>
      slots_;  // frame i waits in slot i modulo their number
  std::size_t next_to_read_ = 0, next_to_deliver_ = 0;
  std::vector<std::jthread> workers_;  // last: they end before what they use does
};

template <typename Read>
Prefetch(Read, std::size_t, const PrefetchOptions& = {})
    -> Prefetch<std::invoke_result_t<Read&, std::size_t>>;

template <typename Frame>
Prefetch<Frame>::Prefetch(Read read, std::size_t count, const PrefetchOptions& options)
    : read_(std::move(read)), count_(count) {
  const int readers = std::clamp(options.threads - 1, 0, kMostReaders);
  slots_.resize(static_cast<std::size_t>(readers * std::max(options.ahead, 1)));
  for (int i = 0; i < readers; ++i)
    workers_.emplace_back([this](const std::stop_token& stop) { work(stop); });
}

template <typename Frame>
Prefetched<Frame> Prefetch<Frame>::read_frame(std::size_t index) const {
  try {
    return {.index = index, .content = read_(index)};
  } catch (const Error& error) {
    return {.index = index, .content = error};
  } catch (const std::exception& error) {
    return {.index = index, .content = Error(ErrorCode::kInternal, error.what())};
  }
}

// There is a frame that nobody reads yet, and a slot for it.
template <typename Frame>
bool Prefetch<Frame>::has_room() const {
  return next_to_read_ < count_ && next_to_read_ < next_to_deliver_ + slots_.size();
}

template <typename Frame>
void Prefetch<Frame>::read_one(std::unique_lock<std::mutex>& lock) {
  const std::size_t index = next_to_read_++;
  lock.unlock();
  Prefetched<Frame> frame = read_frame(index);
  lock.lock();
  slots_[index % slots_.size()] = std::move(frame);
  changed_.notify_all();
}

template <typename Frame>
void Prefetch<Frame>::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (next_to_read_ < count_) {
    const auto worth_waking = [&] { return next_to_read_ >= count_ || has_room(); };
    if (!changed_.wait(lock, stop, worth_waking) || stop.stop_requested()) return;
    if (has_room()) read_one(lock);
  }
}

template <typename Frame>
std::optional<Prefetched<Frame>> Prefetch<Frame>::next() {
  std::unique_lock lock(mutex_);
  if (next_to_deliver_ >= count_) return std::nullopt;
  const std::size_t index = next_to_deliver_;
  if (slots_.empty()) {
    ++next_to_deliver_;
    return read_frame(index);
  }
  std::optional<Prefetched<Frame>>& slot = slots_[index % slots_.size()];
  while (!slot.has_value()) {
    if (has_room())
      read_one(lock);
    else
      changed_.wait(lock);
  }
  std::optional<Prefetched<Frame>> frame = std::exchange(slot, std::nullopt);
  ++next_to_deliver_;
  changed_.notify_all();
  return frame;
}

}  // namespace edvo
