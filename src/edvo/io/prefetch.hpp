// SPDX-License-Identifier: MIT
// Frames read and decoded ahead of who needs them.
#pragma once

#include "edvo/core/error.hpp"
#include "edvo/core/image.hpp"

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

namespace edvo {

// A frame in its place in the sequence, or why it could not be read.
struct FetchedFrame {
  std::size_t index = 0;
  std::variant<RgbdImage, Error> content;
};

struct PrefetchOptions {
  int threads = 2;  // of the whole program: 1 = read when asked, otherwise threads - 1 read ahead
  int ahead = 4;    // frames in memory at most, per reading thread
};

// Delivers frames 0 to count - 1 in order, the same for any number of threads. May be destroyed at
// any time; then it waits only for reads that have begun.
class Prefetch {
 public:
  using Read = std::function<RgbdImage(std::size_t)>;  // called from several threads at once

  Prefetch(Read read, std::size_t count, const PrefetchOptions& options = {});

  // The next frame, empty after the last one.
  [[nodiscard]] std::optional<FetchedFrame> next();

 private:
  void work(const std::stop_token& stop);

  Read read_;
  std::size_t count_;
  std::mutex mutex_;  // of all that follows
  std::condition_variable_any changed_;
  std::vector<std::optional<FetchedFrame>> slots_;  // frame i waits in slot i modulo their number
  std::size_t next_to_read_ = 0, next_to_deliver_ = 0;
  std::vector<std::jthread> workers_;  // last: they end before what they use does
};

}  // namespace edvo
