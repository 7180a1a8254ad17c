// SPDX-License-Identifier: MIT
#include "edvo/source/folder_source.hpp"

#include "support/error_matcher.hpp"
#include "support/sliding_sequence.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::sliding_stamp;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Folder : public testing::Test {
 protected:
  Folder() { test::write_sliding_sequence(sequence()); }
  [[nodiscard]] fs::path sequence() const { return folder_.path() / "sliding"; }

  test::TemporaryFolder folder_;
};

TEST_F(Folder, DescribesTheSequenceItsCameraAndItsGroundTruth) {
  const FolderSource source(sequence());
  const SourceInfo& info = source.info();
  EXPECT_EQ(info.name, "sliding");
  EXPECT_THAT(info.origin, HasSubstr(sequence().string()));
  EXPECT_EQ(info.camera.pinhole.fx, 130);
  EXPECT_THAT(info.camera_origin, HasSubstr("calibration.txt"));
  EXPECT_EQ(info.depth_scale, 5000);
  EXPECT_THAT(info.depth_origin, HasSubstr("5000 units per metre"));
  EXPECT_EQ(info.frames, 12);
  EXPECT_FALSE(info.is_live);
  ASSERT_TRUE(info.ground_truth);
  EXPECT_EQ(info.ground_truth->trajectory.size(), 12u);
  EXPECT_THAT(info.warnings, IsEmpty());
}

TEST_F(Folder, GivesItsFramesInOrderAndEnds) {
  FolderSource source(sequence());
  for (int i = 0; i < 12; ++i) {
    const auto frame = source.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(to_string(frame->stamp), sliding_stamp(i));
    const RgbdImage image = frame->load();
    EXPECT_EQ(image.stamp, frame->stamp);
    EXPECT_EQ(image.depth(5, 5), 2.0F);
  }
  EXPECT_FALSE(source.next());
  source.rewind();
  EXPECT_EQ(source.next()->index, 0);
}

TEST_F(Folder, TakesThePartAskedFor) {
  FolderSource source(sequence(), {.first = 3, .max_frames = 2});
  EXPECT_EQ(source.info().frames, 2);
  EXPECT_EQ(source.next()->index, 3);
  EXPECT_EQ(source.next()->index, 4);
  EXPECT_FALSE(source.next());
  EXPECT_EQ(FolderSource(sequence(), {.first = 10, .max_frames = 5}).info().frames, 2);
  EXPECT_TRUE(test::fails_with(ErrorCode::kUsage, {"only 12 frames"},
                               [&] { (void)FolderSource(sequence(), {.first = 12}); }));
}

TEST_F(Folder, KnowsTheStampOfAFrameThatCannotBeRead) {
  const fs::path damaged = sequence() / "rgb" / (sliding_stamp(2) + ".png");
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  FolderSource source(sequence(), {.first = 2});
  const auto frame = source.next();
  EXPECT_EQ(to_string(frame->stamp), sliding_stamp(2));
  EXPECT_TRUE(
      test::fails_with(ErrorCode::kInput, {damaged.string()}, [&] { (void)frame->load(); }));
  EXPECT_EQ(source.next()->load().stamp, parse_stamp(sliding_stamp(3)));
}

TEST_F(Folder, AGroundTruthThatCannotBeReadIsAWarning) {
  std::ofstream(sequence() / "groundtruth.txt") << "1 2 3\n";
  const FolderSource source(sequence());
  EXPECT_FALSE(source.info().ground_truth);
  EXPECT_THAT(source.info().warnings, ElementsAre(HasSubstr("no evaluation")));
}

}  // namespace
}  // namespace edvo
