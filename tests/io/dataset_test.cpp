// SPDX-License-Identifier: MIT
#include "edvo/io/dataset.hpp"

#include "support/error_matcher.hpp"
#include "support/small_sequence.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::fails_with;
using test::kSmallHeight;
using test::kSmallWidth;
using test::TemporaryFolder;
using test::write_colour;
using test::write_depth;
using test::write_tum_sequence;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// A folder with images 0 to 2 in rgb/ and depth/ and the lists given.
struct Lists {
  explicit Lists(const std::string& rgb, const std::string& depth) {
    for (int i = 0; i < 3; ++i) {
      write_colour(folder.path() / fmt::format("rgb/{}.png", i), i);
      write_depth(folder.path() / fmt::format("depth/{}.png", i), 5000 + i);
    }
    folder.write("rgb.txt", rgb);
    folder.write("depth.txt", depth);
  }
  [[nodiscard]] Dataset open() const { return open_dataset(folder.path()); }
  TemporaryFolder folder;
};

constexpr const char* kRgb = "1.00 rgb/0.png\n1.10 rgb/1.png\n1.20 rgb/2.png\n";
constexpr const char* kDepth = "1.01 depth/0.png\n1.11 depth/1.png\n1.21 depth/2.png\n";

// The frames by the colour values of their images.
std::vector<int> order(const Dataset& dataset) {
  std::vector<int> values;
  for (std::size_t i = 0; i < dataset.frames.size(); ++i)
    values.push_back(read_frame(dataset, i).bgr(0, 0)[0]);
  return values;
}

TEST(Dataset, ManyStampsOutOfOrderAreSaidToBeWrong) {
  const Lists lists("0.031 rgb/0.png\n0.007 rgb/1.png\n0.016 rgb/2.png\n",
                    "0.031 depth/0.png\n0.007 depth/1.png\n0.016 depth/2.png\n");
  EXPECT_THAT(lists.open().warnings,
              Contains(HasSubstr("rgb.txt:2: time stamp 0.007 is earlier than the one before; "
                                 "sorted. 1 of 3 lines are: the stamps are probably wrong")));
}

TEST(Dataset, TumListsGiveFramesWithTheColourStamp) {
  const TemporaryFolder folder;
  write_tum_sequence(folder.path() / "fr1_tiny", 4);
  const Dataset dataset = open_dataset(folder.path() / "fr1_tiny");
  EXPECT_EQ(dataset.name, "fr1_tiny");
  EXPECT_EQ(dataset.colour_count, 4U);
  EXPECT_EQ(dataset.depth_count, 4U);
  EXPECT_EQ(dataset.image_size, cv::Size(kSmallWidth, kSmallHeight));
  EXPECT_EQ(dataset.depth_scale.units_per_metre, 5000);
  EXPECT_FALSE(dataset.ground_truth);
  EXPECT_THAT(dataset.warnings, IsEmpty());
  ASSERT_THAT(dataset.frames, SizeIs(4));
  EXPECT_EQ(to_string(dataset.frames[1].stamp), "10.100");
  EXPECT_EQ(to_string(dataset.frames[1].depth_stamp), "10.105");
  const RgbdImage image = read_frame(dataset, 1);
  EXPECT_EQ(to_string(image.stamp), "10.100");
  EXPECT_EQ(image.bgr(3, 3), cv::Vec3b(1, 1, 1));
  EXPECT_EQ(image.depth(3, 3), 5001.0F / 5000.0F);
}

TEST(Dataset, IsFoundOneFolderDownAndKeepsTheOuterName) {
  const TemporaryFolder folder;
  write_tum_sequence(folder.path() / "outer/fr2_inner", 2);
  const Dataset dataset = open_dataset(folder.path() / "outer/");
  EXPECT_EQ(dataset.name, "outer");
  EXPECT_EQ(dataset.root.filename(), "fr2_inner");
  EXPECT_THAT(dataset.depth_scale.source, HasSubstr("fr2"));
}

TEST(Dataset, FindsTheGroundTruthBeside) {
  const TemporaryFolder folder;
  write_tum_sequence(folder.path(), 1);
  folder.write("livingRoom0.gt.freiburg", "");
  EXPECT_EQ(open_dataset(folder.path()).ground_truth, folder.path() / "livingRoom0.gt.freiburg");
  folder.write("groundtruth.txt", "");
  EXPECT_EQ(open_dataset(folder.path()).ground_truth, folder.path() / "groundtruth.txt");
}

TEST(Dataset, ListsMayHaveWindowsLineEndsMarksCommentsBlankLinesQuotesAndCommas) {
  const Lists lists("\xef\xbb\xbf# colour\r\n\r\n  1.00 rgb/0.png\r\n1.10\t\"rgb/1.png\"\r\n",
                    "1.01,depth/0.png\n\n #x\n 1.11, 'depth/1.png'");
  const Dataset dataset = lists.open();
  EXPECT_THAT(order(dataset), testing::ElementsAre(0, 1));
  EXPECT_THAT(dataset.warnings, IsEmpty());
}

TEST(Dataset, AWrongFieldCountNamesFileAndLine) {
  const Lists one("1.00 rgb/0.png\n1.10\n", kDepth);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"rgb.txt:2: expected 2 fields, got 1"},
                         [&] { (void)one.open(); }));
  const Lists three(kRgb, "1.01 depth/0.png\n# 2\n1.11 my depth/1.png\n");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"depth.txt:3: expected 2 fields, got 3"},
                         [&] { (void)three.open(); }));
  const Lists open_quote("1.00 \"rgb/0.png\n", kDepth);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"rgb.txt:1: quote without its end"},
                         [&] { (void)open_quote.open(); }));
}

TEST(Dataset, AStampThatIsNoTimeNamesFileLineAndValue) {
  for (const char* const value : {"nan", "inf", "1e300", "abc", "1403636579763555584", "9e9"}) {
    const Lists lists(fmt::format("1.00 rgb/0.png\n{} rgb/1.png\n", value), kDepth);
    EXPECT_TRUE(fails_with(ErrorCode::kInput,
                           {"rgb.txt:2: time stamp", fmt::format("'{}'", value), "seconds"},
                           [&] { (void)lists.open(); }));
  }
}

TEST(Dataset, AListThatIsNoTextIsRefused) {
  const Lists utf16(std::string("\xff\xfe\x31\0\x2e\0", 6), kDepth);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"rgb.txt", "UTF-16"}, [&] { (void)utf16.open(); }));
  const Lists control("\x1b[31m rgb/0.png\n", kDepth);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"'?[31m'"}, [&] { (void)control.open(); }));
}

TEST(Dataset, AnEmptyListIsAnError) {
  const Lists lists("# nothing\n", kDepth);
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"rgb.txt: lists no image"}, [&] { (void)lists.open(); }));
}

TEST(Dataset, OfEqualStampsTheFirstIsKept) {
  const Lists lists("1.00 rgb/0.png\n1.00 rgb/1.png\n1.000 rgb/1.png\n1.20 rgb/2.png\n", kDepth);
  const Dataset dataset = lists.open();
  EXPECT_THAT(order(dataset), testing::ElementsAre(0, 2));
  EXPECT_EQ(dataset.colour_count, 2U);
  EXPECT_THAT(dataset.warnings,
              testing::ElementsAre(HasSubstr("rgb.txt:2: time stamp already seen; 2 such lines")));
}

TEST(Dataset, UnorderedStampsAreSorted) {
  const Lists lists("1.10 rgb/1.png\n1.00 rgb/0.png\n1.20 rgb/2.png\n", kDepth);
  const Dataset dataset = lists.open();
  EXPECT_THAT(order(dataset), testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(dataset.warnings, testing::ElementsAre(HasSubstr("rgb.txt:2: time stamp 1.00")));
}

TEST(Dataset, NoPairInReachTellsTheSmallestGapAndBothRanges) {
  const Lists lists(kRgb, "1.03 depth/0.png\n7.5 depth/1.png\n");
  EXPECT_TRUE(fails_with(
      ErrorCode::kInput,
      {"within 0.02 s", "smallest gap is 0.030000 s", "from 1.00 to 1.20", "from 1.03 to 7.5"},
      [&] { (void)lists.open(); }));
  EXPECT_THAT(open_dataset(lists.folder.path(), {.largest_gap = 0.04}).frames, SizeIs(1));
}

TEST(Dataset, AMissingImageIsWarnedOfAndFailsOnlyItsFrame) {
  const Lists lists(kRgb, kDepth);
  fs::remove(lists.folder.path() / "depth/1.png");
  const Dataset dataset = lists.open();
  ASSERT_THAT(dataset.frames, SizeIs(3));
  EXPECT_THAT(dataset.warnings, Contains(HasSubstr("1 of 3 frames lack an image file")));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"depth/1.png: no such file"},
                         [&] { (void)read_frame(dataset, 1); }));
  EXPECT_EQ(read_frame(dataset, 2).bgr(0, 0)[0], 2);
}

TEST(Dataset, AllImagesMissingIsAnError) {
  const Lists lists(kRgb, kDepth);
  fs::remove_all(lists.folder.path() / "rgb");
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"3 of 3 frames", "rgb/0.png"}, [&] { (void)lists.open(); }));
}

TEST(Dataset, ADamagedImageFailsOnlyItsFrameEvenIfItIsTheFirst) {
  const Lists lists(kRgb, kDepth);
  fs::resize_file(lists.folder.path() / "depth/0.png", 60);
  const Dataset dataset = lists.open();
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"depth/0.png: truncated or damaged PNG"},
                         [&] { (void)read_frame(dataset, 0); }));
  EXPECT_EQ(read_frame(dataset, 1).bgr(0, 0)[0], 1);
}

TEST(Dataset, NoReadableFrameIsAnErrorThatShowsTheFirstReason) {
  const Lists lists(kRgb, kDepth);
  for (int i = 0; i < 3; ++i)
    write_png(lists.folder.path() / fmt::format("depth/{}.png", i),
              cv::Mat(kSmallHeight, kSmallWidth, CV_8UC1, cv::Scalar(7)));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"none of the 3 frames", "depth/0.png: 8-bit gray"},
                         [&] { (void)lists.open(); }));
}

TEST(Dataset, DepthOfAnotherSizeThanColourIsAnErrorOfTheWholeIfItIsSoAtOnce) {
  const Lists lists(kRgb, kDepth);
  write_depth(lists.folder.path() / "depth/0.png", 5000, {4, 3});
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"depth of 4 x 3 px", "10 x 8 px", "registered"},
                         [&] { (void)lists.open(); }));
}

TEST(Dataset, DepthThatIsNotRegisteredHasASizeOfItsOwn) {
  const Lists lists(kRgb, kDepth);
  for (int i = 0; i < 2; ++i)
    write_depth(lists.folder.path() / fmt::format("depth/{}.png", i), 5000, {4, 3});
  const Dataset dataset = open_dataset(lists.folder.path(), {.is_depth_registered = false});
  EXPECT_EQ(dataset.depth_size, cv::Size(4, 3));
  EXPECT_EQ(read_frame(dataset, 1).depth.size(), cv::Size(4, 3));
  EXPECT_EQ(read_frame(dataset, 1).bgr.size(), cv::Size(kSmallWidth, kSmallHeight));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"depth/2.png: 10 x 8 px", "the sequence has 4 x 3"},
                         [&] { (void)read_frame(dataset, 2); }));
}

TEST(Dataset, OtherSizesLaterFailOnlyTheirFrame) {
  const Lists lists(kRgb, kDepth);
  write_depth(lists.folder.path() / "depth/1.png", 5000, {4, 3});
  write_depth(lists.folder.path() / "depth/2.png", 5000, {4, 3});
  write_colour(lists.folder.path() / "rgb/2.png", 2, {4, 3});
  const Dataset dataset = lists.open();
  EXPECT_TRUE(
      fails_with(ErrorCode::kInput, {"depth of 4 x 3 px"}, [&] { (void)read_frame(dataset, 1); }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"rgb/2.png: 4 x 3 px", "the sequence has 10 x 8"},
                         [&] { (void)read_frame(dataset, 2); }));
}

TEST(Dataset, ImagesOutsideTheFolderAreReadWithAWarning) {
  const TemporaryFolder elsewhere;
  write_colour(elsewhere.path() / "c.png", 9);
  const Lists lists("1.00 " + (elsewhere.path() / "c.png").string() + "\n", kDepth);
  const Dataset dataset = lists.open();
  EXPECT_THAT(order(dataset), testing::ElementsAre(9));
  EXPECT_THAT(dataset.warnings, Contains(HasSubstr("1 images lie outside the folder")));
}

TEST(Dataset, AnAssociationFileMayHaveDepthFirst) {
  const TemporaryFolder folder;
  for (int i = 0; i < 3; ++i) {
    write_colour(folder.path() / fmt::format("rgb/{}.png", i), i);
    write_depth(folder.path() / fmt::format("depth/{}.png", i), 5000);
  }
  folder.write("associations.txt",
               "0 depth/0.png 0 rgb/0.png\n1 depth/1.png 1 rgb/1.png\n2 depth/2.png 2 rgb/2.png\n");
  const Dataset dataset = open_dataset(folder.path());
  EXPECT_THAT(order(dataset), testing::ElementsAre(0, 1, 2));
  EXPECT_EQ(to_string(dataset.frames[2].stamp), "2");
  EXPECT_THAT(dataset.layout, HasSubstr("associations.txt"));
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("frame numbers")));
}

TEST(Dataset, AnAssociationFileMayHaveColourFirstAndKeepsDistantPairsWithAWarning) {
  const TemporaryFolder folder;
  write_colour(folder.path() / "a/0.png", 4);
  write_depth(folder.path() / "a/0_depth.png", 5000);
  folder.write("associate.txt", "1.5 a/0.png 1.6 a/0_depth.png\n");
  const Dataset dataset = open_dataset(folder.path());
  EXPECT_THAT(order(dataset), testing::ElementsAre(4));
  EXPECT_EQ(to_string(dataset.frames[0].stamp), "1.5");
  EXPECT_THAT(dataset.warnings, Contains(HasSubstr("1 of 1 pairs are 0.02 s or more apart")));
}

TEST(Dataset, AnAssociationFileWithoutAHintWhichIsDepthIsAnError) {
  const TemporaryFolder folder;
  folder.write("associated.txt", "1 a/0.png 1 b/0.png\n");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"associated.txt: cannot tell which column"},
                         [&] { (void)open_dataset(folder.path()); }));
  folder.write("associated.txt", "1 a/0.png 1\n");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"associated.txt:1: expected 4 fields, got 3"},
                         [&] { (void)open_dataset(folder.path()); }));
}

TEST(Dataset, NumberedFoldersAreMatchedByNameInNaturalOrder) {
  const TemporaryFolder folder;
  for (const int i : {1, 2, 10}) {
    write_colour(folder.path() / fmt::format("color/{}.png", i), i);
    write_depth(folder.path() / fmt::format("depth/{}.png", i), 1500);
  }
  write_colour(folder.path() / "color/11.png", 11);
  folder.write("color/.hidden.png", "x");
  const Dataset dataset = open_dataset(folder.path(), {.assumed_rate = 4});
  EXPECT_THAT(order(dataset), testing::ElementsAre(1, 2, 10));
  EXPECT_EQ(to_string(dataset.frames[1].stamp), "0.250000");
  EXPECT_EQ(dataset.depth_scale.units_per_metre, 1000);
  EXPECT_THAT(dataset.notes, Contains(HasSubstr("4 frames per second are assumed")));
  EXPECT_THAT(dataset.warnings, Contains(HasSubstr("4 colour and 3 depth images make only 3")));
}

TEST(Dataset, NumberedFoldersAreMatchedByNumberIfNamesDiffer) {
  const TemporaryFolder folder;
  for (const int i : {8, 9, 10}) {
    write_colour(folder.path() / fmt::format("images/img_{}.png", i), i);
    write_depth(folder.path() / fmt::format("depths/d{:05}.png", i), 1000 + i);
  }
  const Dataset dataset = open_dataset(folder.path());
  EXPECT_THAT(order(dataset), testing::ElementsAre(8, 9, 10));
  EXPECT_EQ(read_frame(dataset, 2).depth(0, 0), 1.010F);
}

TEST(Dataset, OneFolderMayHoldColourAndDepth) {
  const TemporaryFolder folder;
  for (int i = 0; i < 3; ++i) {
    write_colour(folder.path() / fmt::format("frame-{:06}.color.png", i), i);
    write_depth(folder.path() / fmt::format("frame-{:06}.depth.png", i), 2000);
    folder.write(fmt::format("frame-{:06}.pose.txt", i), "");
  }
  const Dataset dataset = open_dataset(folder.path());
  EXPECT_THAT(order(dataset), testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(dataset.warnings, testing::Contains(testing::HasSubstr("no ground truth: ")));
}

TEST(Dataset, NamesOfImagesMayBeTheirStamps) {
  struct Names {
    const char *colour, *depth, *stamp;
  };
  for (const Names& names :
       {Names{"1305031102.175304", "1305031102.160407", "1305031102.175304"},
        Names{"1305031102175304123", "1305031102160407123", "1305031102.175304123"},
        Names{"1305031102175304", "1305031102160407", "1305031102.175304"},
        Names{"1305031102175", "1305031102160", "1305031102.175"}}) {
    const TemporaryFolder folder;
    write_colour(folder.path() / "RGB" / (std::string(names.colour) + ".png"), 1);
    write_depth(folder.path() / "Depth" / (std::string(names.depth) + ".png"), 1000);
    const Dataset dataset = open_dataset(folder.path());
    ASSERT_EQ(dataset.frames.size(), 1U);
    EXPECT_EQ(to_string(dataset.frames[0].stamp), names.stamp);
    EXPECT_EQ(dataset.depth_scale.units_per_metre, 1000);
    EXPECT_THAT(dataset.layout, HasSubstr("stamped images in RGB and Depth"));
  }
}

TEST(Dataset, StampsInNamesThatAreTooFarApartAreAnError) {
  const TemporaryFolder folder;
  write_colour(folder.path() / "images/1305031102.175304.png", 1);
  write_depth(folder.path() / "depth_images/1305031103.160407.png", 1);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"no colour image has a depth image within"},
                         [&] { (void)open_dataset(folder.path()); }));
}

TEST(Dataset, NamesThatDoNotMatchNeedLists) {
  const TemporaryFolder folder;
  write_colour(folder.path() / "images/a.png", 1);
  write_depth(folder.path() / "depth_images/b.png", 1);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"1 colour and 1 depth", "rgb.txt and depth.txt"},
                         [&] { (void)open_dataset(folder.path()); }));
}

TEST(Dataset, WhereThereIsNoSequenceTheErrorTellsWhatWasLookedFor) {
  const TemporaryFolder folder;
  EXPECT_TRUE(fails_with(ErrorCode::kInput,
                         {"empty folder", "rgb.txt and depth.txt", "associations.txt", "color.png"},
                         [&] { (void)open_dataset(folder.path()); }));
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"nowhere: no such folder or archive"},
                         [&] { (void)open_dataset(folder.path() / "nowhere"); }));
  folder.write("rgb.txt", kRgb);
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"rgb.txt is there but depth.txt is not"},
                         [&] { (void)open_dataset(folder.path()); }));
  fs::remove(folder.path() / "rgb.txt");
  fs::create_directories(folder.path() / "rgb");
  fs::create_directories(folder.path() / "depth");
  EXPECT_TRUE(fails_with(ErrorCode::kInput, {"rgb: no PNG or JPEG images"},
                         [&] { (void)open_dataset(folder.path()); }));
}

TEST(Dataset, AGivenDepthScaleOverrides) {
  const TemporaryFolder folder;
  write_tum_sequence(folder.path(), 1);
  const Dataset dataset = open_dataset(folder.path(), {.depth_scale = 2500});
  EXPECT_EQ(read_frame(dataset, 0).depth(0, 0), 2.0F);
  EXPECT_EQ(dataset.depth_scale.source, "as given");
  for (const double bad : {0.0, -1.0, std::nan("")})
    EXPECT_TRUE(fails_with(ErrorCode::kUsage, {"depth scale", "positive"},
                           [&] { (void)open_dataset(folder.path(), {.depth_scale = bad}); }));
}

TEST(Dataset, AnImplausibleDepthScaleIsWarnedOfWithALikelyOne) {
  const TemporaryFolder folder;
  write_colour(folder.path() / "rgb/0.png", 0);
  write_depth(folder.path() / "depth/0.png", 30000);
  EXPECT_THAT(open_dataset(folder.path()).warnings, Contains(HasSubstr("--depth-scale 10000")));
}

TEST(Dataset, TheCamerasFileStatesTheDepthScale) {
  const TemporaryFolder folder;
  write_tum_sequence(folder.path() / "fr1", 2);
  const std::string camera = "Camera.fx: 517\nCamera.fy: 516\nCamera.cx: 318\nCamera.cy: 255\n";
  folder.write("fr1/camera.yaml", "%YAML:1.0\n" + camera + "DepthMapFactor: 2500.0\n");
  const Dataset in_folder = open_dataset(folder.path() / "fr1");
  EXPECT_EQ(in_folder.depth_scale.units_per_metre, 2500);
  EXPECT_EQ(in_folder.depth_scale.source, "DepthMapFactor in camera.yaml");
  EXPECT_FALSE(in_folder.depth_scale.is_assumed);

  const auto given = folder.write("given.toml", "depth_scale = 1250\nfx=9\nfy=9\ncx=4\ncy=3\n");
  EXPECT_EQ(open_dataset(folder.path() / "fr1", {.camera_file = given}).depth_scale.units_per_metre,
            1250);
  const auto silent = folder.write("silent.txt", "9 9 4 3\n");
  const Dataset other = open_dataset(folder.path() / "fr1", {.camera_file = silent});
  EXPECT_EQ(other.depth_scale.units_per_metre, 2500);
  EXPECT_EQ(other.depth_scale.source,
            "DepthMapFactor in the folder's camera.yaml, as silent.txt states none");
  EXPECT_EQ(open_dataset(folder.path() / "fr1", {.depth_scale = 10000, .camera_file = given})
                .depth_scale.units_per_metre,
            10000);
}

TEST(Dataset, SaysWhetherTheDepthScaleIsAssumed) {
  const TemporaryFolder folder;
  write_tum_sequence(folder.path() / "mine", 2);
  write_tum_sequence(folder.path() / "fr1_mine", 2);
  const DepthScale assumed = open_dataset(folder.path() / "mine").depth_scale;
  EXPECT_TRUE(assumed.is_assumed);
  EXPECT_THAT(assumed.source, HasSubstr("assumed, usual for TUM lists"));
  EXPECT_FALSE(open_dataset(folder.path() / "fr1_mine").depth_scale.is_assumed);
  EXPECT_FALSE(open_dataset(folder.path() / "mine", {.depth_scale = 5000}).depth_scale.is_assumed);
}

TEST(Dataset, LooksAtDepthBeyondEmptyAndDamagedImages) {
  const TemporaryFolder folder;
  for (int i = 0; i < 40; ++i) {
    write_colour(folder.path() / fmt::format("rgb/{:02}.png", i), i);
    write_depth(folder.path() / fmt::format("depth/{:02}.png", i), i == 38 ? 30000 : 0);
  }
  write_depth(folder.path() / "depth/38.png", 30000);
  write_depth(folder.path() / "depth/39.png", 30001);
  folder.write("depth/00.png", "x");
  EXPECT_THAT(open_dataset(folder.path()).warnings, Contains(HasSubstr("--depth-scale 10000")));
}

// Images 0 to 10 in color/ and depth/, whose names order as numbers, and what a recorder wrote.
struct Numbered {
  explicit Numbered(const std::string& stamps) {
    for (int i = 8; i < 11; ++i) {
      write_colour(folder.path() / fmt::format("color/{}.png", i), i);
      write_depth(folder.path() / fmt::format("depth/{}.png", i), 5000 + i);
    }
    folder.write("timestamps.txt", stamps);
  }
  [[nodiscard]] Dataset open() const { return open_dataset(folder.path()); }
  TemporaryFolder folder;
};

TEST(Dataset, NumberedImagesHaveTheStampsThatARecorderWroteByTheirNumbers) {
  for (const char* const stamps :
       {"8 1758743290.320641\n9 1758743290.5\n10 1758743291.25\n",
        "# index,time\n10,1758743291.25\n8,1758743290.320641\n9,1758743290.5\n"}) {
    const Numbered numbered(stamps);
    const Dataset dataset = numbered.open();
    ASSERT_THAT(dataset.frames, SizeIs(3));
    EXPECT_EQ(to_string(dataset.frames[0].stamp), "1758743290.320641");
    EXPECT_EQ(dataset.frames[2].stamp.nanoseconds, 1758743291'250000000);
    EXPECT_EQ(dataset.frames[2].depth_stamp, dataset.frames[2].stamp);
    EXPECT_THAT(dataset.notes, Contains(HasSubstr("timestamps.txt")));
    EXPECT_THAT(dataset.warnings, IsEmpty());
  }
}

TEST(Dataset, StampsThatDoNotFitTheNumberedImagesAreNotTakenAndItIsSaid) {
  for (const auto& [stamps, problem] : std::vector<std::pair<std::string, std::string>>{
           {"8 1\n9 2\n", "no line for 10.png"},
           {"8 1\n9 2\n10 2\n", "do not increase at 10.png"},
           {"8 1\n9 2\n9 3\n10 4\n", "index 9 was already there"},
           {"1\n2\n3\n", "expected 2 fields"}}) {
    const Numbered numbered(stamps);
    const Dataset dataset = numbered.open();
    EXPECT_EQ(dataset.frames[0].stamp.nanoseconds, 0) << stamps;
    EXPECT_THAT(dataset.notes, Contains(HasSubstr("30 frames per second are assumed")));
    EXPECT_THAT(dataset.warnings, Contains(HasSubstr(problem)));
  }
}

}  // namespace
}  // namespace edvo
