// SPDX-License-Identifier: MIT
#include "edvo/source/prefetch.hpp"

#include "support/error_matcher.hpp"
#include "support/made_source.hpp"

#include <gtest/gtest.h>
#include <atomic>
#include <chrono>
#include <stdexcept>

namespace edvo {
namespace {

using test::FakeLiveSource;
using test::MadeSource;

RgbdImage image_of(std::int64_t index) {
  RgbdImage image;
  image.stamp = {.nanoseconds = index};
  return image;
}

// Frames divisible by seven are damaged, and some take longer than others.
RgbdImage read_or_fail(std::int64_t index) {
  if (index % 3 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (index % 7 == 0) throw Error(ErrorCode::kInput, "damaged " + std::to_string(index));
  return image_of(index);
}

RgbdImage load(const PendingFrame& frame) {
  return frame.load();
}

class PrefetchWithThreads : public testing::TestWithParam<int> {};

TEST_P(PrefetchWithThreads, DeliversEveryFrameAndErrorInItsPlace) {
  constexpr std::int64_t kCount = 100;
  MadeSource source(kCount, read_or_fail);
  Prefetch frames(load, source, {.threads = GetParam()});
  for (std::int64_t i = 0; i < kCount; ++i) {
    const auto frame = frames.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(frame->stamp.nanoseconds, 100'000'000 * i);
    if (i % 7 == 0) {
      const Error* const error = std::get_if<Error>(&frame->content);
      ASSERT_NE(error, nullptr) << i;
      EXPECT_EQ(error->what(), "damaged " + std::to_string(i));
      EXPECT_EQ(error->code(), ErrorCode::kInput);
    } else {
      EXPECT_EQ(std::get<RgbdImage>(frame->content).stamp.nanoseconds, i);
    }
  }
  EXPECT_FALSE(frames.next());
  EXPECT_FALSE(frames.next());
  EXPECT_EQ(frames.dropped(), 0);
}

TEST_P(PrefetchWithThreads, AsksTheSourceFromOneThreadAtATime) {
  class Watched final : public MadeSource {
   public:
    using MadeSource::MadeSource;
    std::optional<PendingFrame> next() override {
      EXPECT_EQ(inside++, 0);
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      auto frame = MadeSource::next();
      --inside;
      return frame;
    }
    std::atomic<int> inside = 0;
  };
  Watched source(60, read_or_fail);
  Prefetch frames(load, source, {.threads = GetParam()});
  std::int64_t count = 0;
  while (const auto frame = frames.next()) EXPECT_EQ(frame->index, count++);
  EXPECT_EQ(count, 60);
}

TEST_P(PrefetchWithThreads, ReadsNoFartherAheadThanAllowed) {
  std::atomic<std::int64_t> reads = 0;
  constexpr int kAhead = 3;
  MadeSource source(1000, [&](std::int64_t i) {
    ++reads;
    return image_of(i);
  });
  Prefetch frames(load, source, {.threads = GetParam(), .ahead = kAhead});
  for (std::int64_t i = 0; i < 50; ++i) {
    ASSERT_TRUE(frames.next());
    EXPECT_LE(reads, i + 1 + kAhead * (GetParam() - 1));
  }
}

TEST_P(PrefetchWithThreads, CanBeDroppedAtAnyTime) {
  for (int taken = 0; taken < 12; ++taken) {
    MadeSource source(1000, read_or_fail);
    Prefetch frames(load, source, {.threads = GetParam()});
    for (int i = 0; i < taken; ++i) ASSERT_TRUE(frames.next());
  }
}

TEST_P(PrefetchWithThreads, AnyExceptionBecomesAnErrorInPlace) {
  MadeSource source(1, [](std::int64_t) -> RgbdImage { throw std::runtime_error("odd"); });
  Prefetch frames(load, source, {.threads = GetParam()});
  const auto frame = frames.next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(std::get<Error>(frame->content).code(), ErrorCode::kInternal);
  EXPECT_STREQ(std::get<Error>(frame->content).what(), "odd");
}

TEST_P(PrefetchWithThreads, AnEmptySequenceEndsAtOnce) {
  MadeSource source(0, read_or_fail);
  Prefetch frames(load, source, {.threads = GetParam()});
  EXPECT_FALSE(frames.next());
}

TEST_P(PrefetchWithThreads, TheErrorOfTheSourceComesAfterItsFrames) {
  MadeSource source(20, image_of);
  source.error = Error(ErrorCode::kInput, "recording: cut short");
  Prefetch frames(load, source, {.threads = GetParam()});
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(frames.next());
  for (int again = 0; again < 2; ++again)
    EXPECT_TRUE(test::fails_with(ErrorCode::kInput, {"cut short"}, [&] { (void)frames.next(); }));
}

INSTANTIATE_TEST_SUITE_P(Any, PrefetchWithThreads, testing::Values(1, 2, 4),
                         testing::PrintToStringParamName());

TEST(Prefetch, OneThreadReadsWhenAsked) {
  std::vector<std::thread::id> readers;
  MadeSource source(5, [&](std::int64_t i) {
    readers.push_back(std::this_thread::get_id());
    return image_of(i);
  });
  Prefetch frames(load, source, {.threads = 1});
  EXPECT_TRUE(readers.empty());
  (void)frames.next();
  EXPECT_EQ(readers, std::vector{std::this_thread::get_id()});
}

TEST(PrefetchLive, TheNewestFrameWinsAndDropsAreCounted) {
  FakeLiveSource camera(image_of);
  Prefetch frames(load, camera, {.threads = 2});
  camera.deliver();
  EXPECT_EQ(frames.next()->index, 0);
  for (int i = 0; i < 5; ++i) camera.deliver();  // frames 1 to 5, while the first is processed
  camera.wait_until_taken();
  EXPECT_EQ(frames.next()->index, 5);
  EXPECT_EQ(frames.dropped(), 4);
}

TEST(PrefetchLive, ReadsOnlyWhatIsUsed) {
  std::vector<std::int64_t> read;
  FakeLiveSource camera([&](std::int64_t i) {
    read.push_back(i);
    return image_of(i);
  });
  Prefetch frames(load, camera, {.threads = 4});
  for (int i = 0; i < 3; ++i) camera.deliver();
  camera.wait_until_taken();
  (void)frames.next();
  EXPECT_EQ(read, std::vector<std::int64_t>{2});
}

TEST(PrefetchLive, TheLastFrameIsDeliveredBeforeTheEnd) {
  FakeLiveSource camera(image_of);
  Prefetch frames(load, camera, {});
  camera.deliver();
  camera.wait_until_taken();
  camera.stop();
  EXPECT_EQ(frames.next()->index, 0);
  EXPECT_FALSE(frames.next());
}

TEST(PrefetchLive, AsksWhetherToStopWhileNothingComes) {
  FakeLiveSource camera(image_of);
  Prefetch frames(load, camera, {});
  int asked = 0;
  EXPECT_FALSE(frames.next([&] { return ++asked == 3; }));
  EXPECT_EQ(asked, 3);
}

TEST(PrefetchLive, CanBeDroppedWhileTheCameraIsSilent) {
  FakeLiveSource camera(image_of);
  const Prefetch frames(load, camera, {});
}

}  // namespace
}  // namespace edvo
