// SPDX-License-Identifier: MIT
#include "edvo/io/prefetch.hpp"

#include "edvo/core/rgbd_image.hpp"

#include <gtest/gtest.h>
#include <atomic>
#include <chrono>
#include <stdexcept>

namespace edvo {
namespace {

// Frame i has stamp i; frames divisible by seven are damaged, and some take longer than others.
RgbdImage read_or_fail(std::size_t index) {
  if (index % 3 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (index % 7 == 0) throw Error(ErrorCode::kInput, "damaged " + std::to_string(index));
  RgbdImage image;
  image.stamp = {.nanoseconds = static_cast<std::int64_t>(index)};
  return image;
}

class PrefetchWithThreads : public testing::TestWithParam<int> {};

TEST_P(PrefetchWithThreads, DeliversEveryFrameAndErrorInItsPlace) {
  constexpr std::size_t kCount = 100;
  Prefetch frames(read_or_fail, kCount, {.threads = GetParam()});
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto frame = frames.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    if (i % 7 == 0) {
      const Error* const error = std::get_if<Error>(&frame->content);
      ASSERT_NE(error, nullptr) << i;
      EXPECT_EQ(error->what(), "damaged " + std::to_string(i));
      EXPECT_EQ(error->code(), ErrorCode::kInput);
    } else {
      EXPECT_EQ(std::get<RgbdImage>(frame->content).stamp.nanoseconds,
                static_cast<std::int64_t>(i));
    }
  }
  EXPECT_FALSE(frames.next());
  EXPECT_FALSE(frames.next());
}

TEST_P(PrefetchWithThreads, ReadsNoFartherAheadThanAllowed) {
  std::atomic<std::size_t> reads = 0;
  constexpr int kAhead = 3;
  Prefetch frames(
      [&](std::size_t) {
        ++reads;
        return RgbdImage{};
      },
      1000, {.threads = GetParam(), .ahead = kAhead});
  for (std::size_t i = 0; i < 50; ++i) {
    ASSERT_TRUE(frames.next());
    EXPECT_LE(reads, i + 1 + static_cast<std::size_t>(kAhead * (GetParam() - 1)));
  }
}

TEST_P(PrefetchWithThreads, CanBeDroppedAtAnyTime) {
  for (std::size_t taken = 0; taken < 12; ++taken) {
    Prefetch frames(read_or_fail, 1000, {.threads = GetParam()});
    for (std::size_t i = 0; i < taken; ++i) ASSERT_TRUE(frames.next());
  }
}

TEST_P(PrefetchWithThreads, AnyExceptionBecomesAnErrorInPlace) {
  Prefetch frames([](std::size_t) -> RgbdImage { throw std::runtime_error("odd"); }, 1,
                  {.threads = GetParam()});
  const auto frame = frames.next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(std::get<Error>(frame->content).code(), ErrorCode::kInternal);
  EXPECT_STREQ(std::get<Error>(frame->content).what(), "odd");
}

TEST_P(PrefetchWithThreads, AnEmptySequenceEndsAtOnce) {
  Prefetch frames(read_or_fail, 0, {.threads = GetParam()});
  EXPECT_FALSE(frames.next());
}

INSTANTIATE_TEST_SUITE_P(Any, PrefetchWithThreads, testing::Values(1, 2, 4));

TEST(Prefetch, OneThreadReadsWhenAsked) {
  std::vector<std::thread::id> readers;
  Prefetch frames(
      [&](std::size_t) {
        readers.push_back(std::this_thread::get_id());
        return RgbdImage{};
      },
      5, {.threads = 1});
  EXPECT_TRUE(readers.empty());
  (void)frames.next();
  EXPECT_EQ(readers, std::vector{std::this_thread::get_id()});
}

}  // namespace
}  // namespace edvo
