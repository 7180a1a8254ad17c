// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/image_file.hpp"
#include "support/program.hpp"
#include "support/temporary_folder.hpp"
#include "support/tiny_network.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace edvo {
namespace {

using test::run_edvo;
using ::testing::HasSubstr;

class EdgesCommand : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(images_);
    write_png(images_ / "a.png", test::bright_square());
    write_png(images_ / "b.png", test::bright_square({80, 60}));
  }

  auto run(const std::string& arguments) const {
    return run_edvo(fmt::format("edges {} -o {} 2>&1", arguments, output_.string()));
  }

  void expect_refused(const std::string& arguments, ErrorCode code, const std::string& part) const {
    const auto result = run(arguments);
    EXPECT_EQ(result.status, static_cast<int>(code)) << result.output;
    EXPECT_THAT(result.output, HasSubstr(part));
    EXPECT_FALSE(std::filesystem::exists(output_));
  }

  test::TemporaryFolder folder_;
  std::filesystem::path images_ = folder_.path() / "images", output_ = folder_.path() / "out";
  std::string model_ = " --model " + test::kTinyModel.string();
};

TEST_F(EdgesCommand, WritesThinEdgesOfAFolderWithEitherDetector) {
  for (const std::string& detector : {std::string(" --detector canny"), model_}) {
    ASSERT_EQ(run(images_.string() + detector + " --force").status, 0);
    for (const char* name : {"a.png", "b.png"}) {
      cv::Mat_<std::uint8_t> edges;
      cv::extractChannel(read_colour(output_ / name), edges, 0);
      EXPECT_EQ(edges.size(), read_colour(images_ / name).size());
      EXPECT_EQ(cv::countNonZero(edges), cv::countNonZero(edges == 255));
      EXPECT_NEAR(cv::countNonZero(edges), 2 * (40 + 30), 20) << detector;
    }
  }
}

TEST_F(EdgesCommand, ReplacesNothingUnasked) {
  ASSERT_EQ(run(images_.string() + " --detector canny").status, 0);
  const auto again = run(images_.string() + " --detector canny");
  EXPECT_EQ(again.status, static_cast<int>(ErrorCode::kOutput));
  EXPECT_THAT(again.output, HasSubstr("--force"));
  EXPECT_EQ(run(images_.string() + " --detector canny --force").status, 0);
}

TEST_F(EdgesCommand, WritesTheStrengthOfOneImage) {
  ASSERT_EQ(run((images_ / "a.png").string() + " --strength" + model_).status, 0);
  const auto strength = read_colour(output_ / "a.png");
  EXPECT_GT(strength(25, 20)[0], 250);
  EXPECT_GT(strength(0, 0)[0], 0);  // not a mask
  EXPECT_LT(strength(0, 0)[0], 30);
}

TEST_F(EdgesCommand, WritesTheStrengthUnroundedForNumPy) {
  for (const std::string& detector : {std::string(" --detector canny"), model_}) {
    ASSERT_EQ(run(images_.string() + " --raw --force" + detector).status, 0);
    const std::string file = read_file(output_ / "a.npy");
    EXPECT_TRUE(file.starts_with("\x93NUMPY\x01"));
    EXPECT_THAT(file, HasSubstr("{'descr': '<f4', 'fortran_order': False, 'shape': (64, 96), }"));
    constexpr std::size_t kHeader = 128;  // [bytes]
    ASSERT_EQ(file.size(), kHeader + 64 * 96 * sizeof(float));
    std::array<float, 3> row{};  // across the left side of the square
    std::memcpy(row.data(), file.data() + kHeader + (25 * 96 + 19) * sizeof(float), sizeof row);
    const float on_edge = *std::ranges::max_element(row);
    EXPECT_GT(on_edge, 0.99F) << detector;
    EXPECT_LE(on_edge, 1.F) << detector;
  }
}

TEST_F(EdgesCommand, HasANetworkOfItsOwn) {
  const auto result = run(images_.string() + " --detector network");
  EXPECT_EQ(result.status, 0) << result.output;
}

TEST_F(EdgesCommand, RefusesWhatItCannotDo) {
  const std::string images = images_.string();
  expect_refused(images + " --model none.toml", ErrorCode::kModel, "none.toml: no such file");
  expect_refused(images + " --detector canny" + model_, ErrorCode::kUsage, "uses no network");
  expect_refused(images + " --detector sobel", ErrorCode::kUsage, "sobel");
  expect_refused(folder_.path().string(), ErrorCode::kInput, "no PNG or JPEG image");
  expect_refused("none.png", ErrorCode::kInput, "none.png: no such file");
}

TEST_F(EdgesCommand, NeverWritesOverItsInput) {
  const auto result = run_edvo(fmt::format("edges {0} -o {0} 2>&1", images_.string()));
  EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(result.output, HasSubstr("a.png would be overwritten"));
}

}  // namespace
}  // namespace edvo
