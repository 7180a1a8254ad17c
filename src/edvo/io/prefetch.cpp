// SPDX-License-Identifier: MIT
#include "edvo/io/prefetch.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace edvo {
namespace {

constexpr int kMostReaders = 4;  // more would only hold more memory: tracking is slower than that

FetchedFrame fetch(const Prefetch::Read& read, std::size_t index) {
  try {
    return {.index = index, .content = read(index)};
  } catch (const Error& error) {
    return {.index = index, .content = error};
  } catch (const std::exception& error) {
    return {.index = index, .content = Error(ErrorCode::kInternal, error.what())};
  }
}

}  // namespace

Prefetch::Prefetch(Read read, std::size_t count, const PrefetchOptions& options)
    : read_(std::move(read)), count_(count) {
  const int readers = std::clamp(options.threads - 1, 0, kMostReaders);
  slots_.resize(static_cast<std::size_t>(readers * std::max(options.ahead, 1)));
  for (int i = 0; i < readers; ++i)
    workers_.emplace_back([this](const std::stop_token& stop) { work(stop); });
}

void Prefetch::work(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (next_to_read_ < count_) {
    const auto has_room = [&] {
      return next_to_read_ >= count_ || next_to_read_ < next_to_deliver_ + slots_.size();
    };
    if (!changed_.wait(lock, stop, has_room) || stop.stop_requested()) return;
    if (next_to_read_ >= count_) return;
    const std::size_t index = next_to_read_++;
    lock.unlock();
    FetchedFrame frame = fetch(read_, index);
    lock.lock();
    slots_[index % slots_.size()] = std::move(frame);
    changed_.notify_all();
  }
}

std::optional<FetchedFrame> Prefetch::next() {
  std::unique_lock lock(mutex_);
  if (next_to_deliver_ >= count_) return std::nullopt;
  const std::size_t index = next_to_deliver_;
  if (slots_.empty()) {
    ++next_to_deliver_;
    return fetch(read_, index);
  }
  std::optional<FetchedFrame>& slot = slots_[index % slots_.size()];
  changed_.wait(lock, [&] { return slot.has_value(); });
  std::optional<FetchedFrame> frame = std::exchange(slot, std::nullopt);
  ++next_to_deliver_;
  changed_.notify_all();
  return frame;
}

}  // namespace edvo
