// SPDX-License-Identifier: MIT
// Frames of any source, read, decoded and prepared ahead of who needs them.
#pragma once

#include "edvo/core/error.hpp"
#include "edvo/source/rgbd_source.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace edvo {

// A frame in its place in the sequence, or why it could not be read.
template <typename Frame>
struct Prefetched {  // NOLINT(bugprone-exception-escape): neither alternative throws when moved
  std::int64_t index = 0;
  Stamp stamp;
  std::variant<Frame, Error> content;
};

struct PrefetchOptions {
  int threads = 2;  // of the whole program: 1 = read when asked, otherwise threads - 1 read ahead
  int ahead = 6;    // frames in memory at most, per reading thread
};

// Delivers the frames of a source in order, the same for any number of threads. Who asks before a
// frame is there reads along instead of waiting, so that no thread is idle. May be destroyed at any
// time; then it stops the source if that is live, and waits only for reads that have begun.
//
// Of a live source one thread takes every frame as it comes, and next() reads the newest; those in
// between are dropped and counted.
template <typename Frame>
class Prefetch {
 public:
  using Read = std::function<Frame(const PendingFrame&)>;  // called from several threads at once
  using ShouldStop = std::function<bool()>;                // asked by the thread that calls next()

  // The source must live longer.
  Prefetch(Read read, RgbdSource& source, const PrefetchOptions& options = {});
  ~Prefetch();
  Prefetch(const Prefetch&) = delete;
  Prefetch& operator=(const Prefetch&) = delete;

  // The next frame, empty after the last one, or if should_stop says so while a live source has
  // none. Throws the error that ended the source, after all frames before it.
  [[nodiscard]] std::optional<Prefetched<Frame>> next(const ShouldStop& should_stop = nullptr);

  // Frames of a live source that came and went unread.
  [[nodiscard]] std::int64_t dropped() const;

 private:
  // More would only hold more memory: tracking is slower than that.
  static constexpr int kMostReaders = 4;

  // A frame that the source has given and next() has not.
  using Slot = std::shared_ptr<std::optional<Prefetched<Frame>>>;

  // What the source gives: a frame, an error, or neither at its end.
  struct Pulled {
    std::optional<PendingFrame> frame;
    std::exception_ptr error;
  };

  [[nodiscard]] Pulled pull();
  void note_end(const Pulled& pulled);
  [[nodiscard]] Prefetched<Frame> read_frame(const PendingFrame& pending) const;
  [[nodiscard]] bool has_room() const;
  void read_one(std::unique_lock<std::mutex>& lock);
  void read_ahead(const std::stop_token& stop);
  void keep_newest(const std::stop_token& stop);
  [[nodiscard]] std::optional<Prefetched<Frame>> next_recorded();
  [[nodiscard]] std::optional<Prefetched<Frame>> next_alone();
  [[nodiscard]] std::optional<Prefetched<Frame>> next_live(const ShouldStop& should_stop);
  [[nodiscard]] std::optional<Prefetched<Frame>> none_or_error() const;

  Read read_;
  RgbdSource& source_;
  std::size_t most_ahead_ = 0;
  mutable std::mutex mutex_;  // of all that follows
  std::condition_variable_any changed_;
  std::deque<Slot> slots_;              // in the order of delivery
  std::optional<PendingFrame> newest_;  // of a live source
  bool pulling_ = false;                // a thread is in source_.next()
  bool ended_ = false;                  // the source has no more frames
  std::exception_ptr error_;            // or why
  std::int64_t dropped_ = 0;
  std::vector<std::jthread> workers_;  // last: they end before what they use does
};

template <typename Read>
Prefetch(Read, RgbdSource&, const PrefetchOptions& = {})
    -> Prefetch<std::invoke_result_t<Read&, const PendingFrame&>>;

template <typename Frame>
Prefetch<Frame>::Prefetch(Read read, RgbdSource& source, const PrefetchOptions& options)
    : read_(std::move(read)), source_(source) {
  if (source.info().is_live) {
    workers_.emplace_back([this](const std::stop_token& stop) { keep_newest(stop); });
    return;
  }
  const int readers = std::clamp(options.threads - 1, 0, kMostReaders);
  most_ahead_ = static_cast<std::size_t>(readers * std::max(options.ahead, 1));
  for (int i = 0; i < readers; ++i)
    workers_.emplace_back([this](const std::stop_token& stop) { read_ahead(stop); });
}

template <typename Frame>
Prefetch<Frame>::~Prefetch() {
  for (std::jthread& worker : workers_) worker.request_stop();
  if (source_.info().is_live) source_.stop();
}

template <typename Frame>
std::int64_t Prefetch<Frame>::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

template <typename Frame>
std::optional<Prefetched<Frame>> Prefetch<Frame>::next(const ShouldStop& should_stop) {
  if (source_.info().is_live) return next_live(should_stop);
  return most_ahead_ == 0 ? next_alone() : next_recorded();
}

template <typename Frame>
std::optional<Prefetched<Frame>> Prefetch<Frame>::next_alone() {
  if (ended_) return none_or_error();
  const Pulled pulled = pull();
  if (pulled.frame) return read_frame(*pulled.frame);
  note_end(pulled);
  return none_or_error();
}

template <typename Frame>
std::optional<Prefetched<Frame>> Prefetch<Frame>::next_recorded() {
  std::unique_lock lock(mutex_);
  while (slots_.empty() || !slots_.front()->has_value()) {
    if (slots_.empty() && ended_) return none_or_error();
    if (has_room())
      read_one(lock);
    else
      changed_.wait(lock);
  }
  std::optional<Prefetched<Frame>> frame = std::move(*slots_.front());
  slots_.pop_front();
  changed_.notify_all();
  return frame;
}

// A signal to stop wakes no thread, so that this one looks up from time to time.
template <typename Frame>
std::optional<Prefetched<Frame>> Prefetch<Frame>::next_live(const ShouldStop& should_stop) {
  constexpr std::chrono::milliseconds kLookUp{50};
  std::unique_lock lock(mutex_);
  while (!newest_ && !ended_) {
    if (should_stop && should_stop()) return std::nullopt;
    changed_.wait_for(lock, kLookUp);
  }
  if (!newest_) return none_or_error();
  const PendingFrame pending = *std::exchange(newest_, std::nullopt);
  lock.unlock();
  return read_frame(pending);
}

template <typename Frame>
std::optional<Prefetched<Frame>> Prefetch<Frame>::none_or_error() const {
  if (error_) std::rethrow_exception(error_);
  return std::nullopt;
}

// Without the lock: a recording reads here. One thread at a time.
template <typename Frame>
typename Prefetch<Frame>::Pulled Prefetch<Frame>::pull() {
  try {
    return {.frame = source_.next(), .error = nullptr};
  } catch (...) {
    return {.frame = std::nullopt, .error = std::current_exception()};
  }
}

template <typename Frame>
void Prefetch<Frame>::note_end(const Pulled& pulled) {
  ended_ = !pulled.frame;
  error_ = pulled.error;
}

template <typename Frame>
Prefetched<Frame> Prefetch<Frame>::read_frame(const PendingFrame& pending) const {
  const auto failed = [&](const Error& error) {
    return Prefetched<Frame>{.index = pending.index, .stamp = pending.stamp, .content = error};
  };
  try {
    return {.index = pending.index, .stamp = pending.stamp, .content = read_(pending)};
  } catch (const std::bad_alloc&) {  // the next frame may be smaller
    return failed(Error(ErrorCode::kInput, "not enough memory for this frame"));
  } catch (...) {
    return failed(caught_error());
  }
}

// There may be a frame that nobody reads yet, and there is room for it.
template <typename Frame>
bool Prefetch<Frame>::has_room() const {
  return !ended_ && !pulling_ && slots_.size() < most_ahead_;
}

template <typename Frame>
void Prefetch<Frame>::read_one(std::unique_lock<std::mutex>& lock) {
  pulling_ = true;
  lock.unlock();
  const Pulled pulled = pull();
  lock.lock();
  pulling_ = false;
  note_end(pulled);
  changed_.notify_all();
  if (!pulled.frame) return;
  const Slot slot = slots_.emplace_back(std::make_shared<typename Slot::element_type>());
  lock.unlock();
  Prefetched<Frame> frame = read_frame(*pulled.frame);
  lock.lock();
  *slot = std::move(frame);
  changed_.notify_all();
}

template <typename Frame>
void Prefetch<Frame>::read_ahead(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!ended_) {
    const auto worth_waking = [&] { return ended_ || has_room(); };
    if (!changed_.wait(lock, stop, worth_waking) || stop.stop_requested()) return;
    if (has_room()) read_one(lock);
  }
}

template <typename Frame>
void Prefetch<Frame>::keep_newest(const std::stop_token& stop) {
  for (bool ended = false; !ended && !stop.stop_requested();) {
    Pulled pulled = pull();
    ended = !pulled.frame;
    const std::lock_guard lock(mutex_);
    note_end(pulled);
    if (pulled.frame) {
      if (newest_) ++dropped_;
      newest_ = std::move(pulled.frame);
    }
    changed_.notify_all();
  }
}

}  // namespace edvo
