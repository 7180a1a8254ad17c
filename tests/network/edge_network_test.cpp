// SPDX-License-Identifier: MIT
#include "edvo/network/edge_network.hpp"

#include "edvo/core/sha256.hpp"
#include "edvo/network/onnx_graph.hpp"
#include "support/error_matcher.hpp"
#include "support/tiny_network.hpp"

#include <gmock/gmock.h>

#include <bit>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>

namespace edvo {
namespace {

using test::bright_square;
using test::fails_with;
using test::patched;
using test::tiny_model;

constexpr float kLumaOfGreen = 0.587F;  // a weight of the tiny network
const cv::Size kSize(96, 64);           // [px]

std::string bytes_of(float value) {
  const auto bits = std::bit_cast<std::array<char, sizeof value>>(value);
  return {bits.data(), bits.size()};
}

testing::AssertionResult is_refused(const Model& model, std::initializer_list<std::string> parts,
                                    cv::Size size = kSize) {
  return fails_with(ErrorCode::kModel, parts, [&] { (void)make_network_strength(model, size); });
}

bool same_bits(const cv::Mat_<float>& a, const cv::Mat_<float>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
}

class Network : public testing::Test {
 protected:
  void SetUp() override { cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT); }
  Model model_ = tiny_model();
};

TEST_F(Network, FindsTheSidesOfASquareAndNothingElse) {
  const auto detector = make_network_strength(model_, kSize);
  const cv::Mat_<float> strength = detector->strength(bright_square());
  ASSERT_EQ(strength.size(), kSize);
  EXPECT_GT(strength(25, 20), 0.99F);
  EXPECT_GT(strength(10, 40), 0.99F);
  EXPECT_LT(strength(25, 40), 0.1F);
  EXPECT_LT(strength(0, 0), 0.1F);
  double lowest = 0, highest = 0;
  cv::minMaxLoc(strength, &lowest, &highest);
  EXPECT_GE(lowest, 0);
  EXPECT_LE(highest, 1);
}

TEST_F(Network, GivesTheSameBitsTwiceAndWithAnyNumberOfThreads) {
  const int threads = cv::getNumThreads();
  const cv::Mat_<cv::Vec3b> image = bright_square({640, 480});
  const cv::Mat_<float> first = make_network_strength(model_, image.size())->strength(image);
  const auto detector = make_network_strength(model_, image.size());
  for (const int count : {1, 2}) {
    cv::setNumThreads(count);
    EXPECT_TRUE(same_bits(detector->strength(image), first)) << count << " threads";
  }
  cv::setNumThreads(threads);
}

TEST_F(Network, KeepsTheImageUnderPadding) {
  const cv::Mat_<cv::Vec3b> image = bright_square({90, 61});
  const cv::Mat_<float> exact = make_network_strength(model_, image.size())->strength(image);
  for (const Padding padding : {Padding::kReflect, Padding::kReplicate}) {
    model_.description.input.multiple_of = 16;
    model_.description.input.padding = padding;
    const cv::Mat_<float> padded = make_network_strength(model_, image.size())->strength(image);
    EXPECT_LT(cv::norm(padded, exact, cv::NORM_INF), 1e-4);
  }
}

TEST_F(Network, AnswersInTheSizeOfTheImageWhateverItsOwn) {
  const auto finds_the_square = [&] {
    const auto strength = make_network_strength(model_, kSize)->strength(bright_square());
    EXPECT_EQ(strength.size(), kSize);
    EXPECT_GT(strength(25, 20), 0.5F);
    EXPECT_LT(strength(25, 40), 0.1F);
  };
  model_.description.input.size = {128, 96};
  finds_the_square();
  model_.description.input.size = {};
  for (const double factor : {0.5, 2.0}) {
    model_.description.input.factor = factor;
    finds_the_square();
  }
}

TEST_F(Network, OrdersAndShiftsChannelsAsDescribed) {
  NetworkInput& input = model_.description.input;
  cv::Mat_<cv::Vec3b> swapped;
  cv::cvtColor(bright_square(), swapped, cv::COLOR_BGR2RGB);
  const cv::Mat_<float> expected = make_network_strength(model_, kSize)->strength(bright_square());
  input.channels = ChannelOrder::kRgb;
  EXPECT_TRUE(same_bits(make_network_strength(model_, kSize)->strength(swapped), expected));

  input.mean = {10, 20, 30};  // a constant has no edges
  const auto shifted = make_network_strength(model_, kSize)->strength(swapped);
  EXPECT_LT(cv::norm(shifted, expected, cv::NORM_INF), 1e-3);
}

TEST_F(Network, ChoosesItsOutputByNameOrByPlaceInTheFile) {
  EXPECT_EQ(onnx_outputs(model_.weights), (std::vector<std::string>{"edges", "coarse"}));
  model_.description.output.name = "edges";
  EXPECT_TRUE(make_network_strength(model_, kSize));
  model_.description.output.name = "edgse";
  EXPECT_TRUE(is_refused(model_, {"tiny_edges.onnx", "did you mean 'edges'?", "edges, coarse"}));
  model_.description.output = {.name = "", .index = 2};
  EXPECT_TRUE(is_refused(model_, {"tiny_edges.onnx: output.index 2 is out of range"}));
}

TEST_F(Network, RefusesWhatIsNoOnnxFile) {
  for (const std::string& bytes : {std::string(), std::string("not a network"),
                                   std::string("\x89PNG\r\n\x1a\n"), std::string(1000, '\0')}) {
    model_.weights = bytes;
    EXPECT_TRUE(is_refused(model_, {"tiny_edges.onnx: not an ONNX file"}));
  }
}

TEST_F(Network, RefusesATruncatedFileWhereverItEnds) {
  const std::string whole = model_.weights;
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    model_.weights = whole.substr(0, length);
    EXPECT_TRUE(is_refused(model_, {"tiny_edges.onnx: "})) << length << " bytes";
  }
}

TEST_F(Network, RefusesAnOperatorThatOpenCvDoesNotKnow) {
  model_.weights = patched(model_.weights, "Sqrt", "Sqrr");
  EXPECT_TRUE(is_refused(model_, {"tiny_edges.onnx: OpenCV", "cannot load", "Sqrr"}));
}

TEST_F(Network, RefusesWeightsThatAreNotFinite) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Model broken = model_;
    broken.weights = patched(model_.weights, bytes_of(kLumaOfGreen), bytes_of(bad));
    EXPECT_TRUE(is_refused(broken, {"tiny_edges.onnx: the weights"}));
  }
}

TEST_F(Network, RefusesAnOutputThatIsNotFinite) {
  model_.description.input.scale = 1e6;
  model_.weights = patched(model_.weights, bytes_of(kLumaOfGreen), bytes_of(3e38F));
  const auto detector = make_network_strength(model_, kSize);  // black times anything is fine
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"output 'edges' is not finite everywhere"},
                         [&] { (void)detector->strength(bright_square()); }));
}

TEST_F(Network, RefusesAnOutputOfAnotherSize) {
  model_.description.output.index = 1;
  EXPECT_TRUE(is_refused(
      model_, {"output 'coarse' has the shape 1 x 1 x 32 x 48", "1 x 1 x 64 x 96 is expected"}));
}

TEST_F(Network, RefusesAnOutputThatIsNoProbability) {
  model_.description.output.activation = Activation::kNone;
  EXPECT_TRUE(is_refused(model_, {"goes from -3 to -3 instead of 0 to 1", "sigmoid"}));
}

TEST_F(Network, RefusesAnImageSmallerThanItsStride) {
  model_.description.input.multiple_of = 32;
  EXPECT_TRUE(is_refused(model_, {"an image of 96 x 20 px is too small", "32 px"}, {96, 20}));
  EXPECT_TRUE(make_network_strength(model_, {33, 32}));
}

TEST_F(Network, IsEdvosOwnWhereNoneIsNamed) {
  // A dark square on a light ground: its border is an edge, its middle is none.
  cv::Mat_<cv::Vec3b> image(96, 128, cv::Vec3b(200, 200, 200));
  image(cv::Rect(40, 30, 40, 40)) = cv::Vec3b(60, 60, 60);
  const cv::Mat_<float> strength = open_network({}, image.size())->strength(image);
  float border = 0;
  for (int x = 38; x <= 41; ++x) border = std::max(border, strength(50, x));
  EXPECT_GT(border, 0.5F);
  EXPECT_LT(strength(50, 60), 0.2F);
  EXPECT_EQ(own_model().description.sha256, sha256(own_model().weights));
}

TEST_F(Network, IsTheOneNamed) {
  EXPECT_TRUE(open_network({.model = test::kTinyModel.string()}, kSize));
}

}  // namespace
}  // namespace edvo
