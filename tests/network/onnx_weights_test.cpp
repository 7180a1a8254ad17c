// SPDX-License-Identifier: MIT
#include "edvo/network/onnx_weights.hpp"

#include "edvo/io/file.hpp"
#include "edvo/network/edge_network.hpp"
#include "edvo/network/onnx_tensor.hpp"
#include "edvo/network/protobuf.hpp"
#include "support/error_matcher.hpp"
#include "support/tiny_network.hpp"

#include <gmock/gmock.h>

#include <cstring>

namespace edvo {
namespace {

using test::fails_with;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

template <typename Number>
OnnxTensor tensor(OnnxType type, std::vector<std::int64_t> dims, std::vector<Number> numbers) {
  return {.dims = std::move(dims),
          .type = type,
          .data = {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)}};
}

OnnxTensor bytes(std::vector<std::int64_t> dims, std::vector<std::int8_t> numbers) {
  return tensor(OnnxType::kInt8, std::move(dims), std::move(numbers));
}

OnnxTensor floats(std::vector<std::int64_t> dims, std::vector<float> numbers) {
  return tensor(OnnxType::kFloat, std::move(dims), std::move(numbers));
}

OnnxTensor shape(std::vector<std::int64_t> sides) {
  return tensor(OnnxType::kInt64, {static_cast<std::int64_t>(sides.size())}, sides);
}

std::vector<float> values(const OnnxTensor& tensor) {
  std::vector<float> numbers(tensor.data.size() / sizeof(float));
  std::memcpy(numbers.data(), tensor.data.data(), tensor.data.size());
  return numbers;
}

testing::AssertionResult is_refused(const OnnxTensor& numbers, const OnnxTensor& scale,
                                    const Quantization& quantization, const std::string& part) {
  return fails_with(ErrorCode::kModel, {part},
                    [&] { (void)dequantized(numbers, scale, {}, quantization); });
}

TEST(OnnxTensor, RestoresFloatsFromOneScaleScalesPerAxisAndBlocks) {
  const OnnxTensor numbers = bytes({2, 4}, {1, 2, 3, 4, -5, -6, -7, -8});
  EXPECT_THAT(values(dequantized(numbers, floats({}, {2}), bytes({}, {1}), {})),
              ElementsAre(0, 2, 4, 6, -12, -14, -16, -18));
  EXPECT_THAT(values(dequantized(numbers, floats({2}, {1, 10}), {}, {.axis = 0})),
              ElementsAre(1, 2, 3, 4, -50, -60, -70, -80));
  EXPECT_THAT(values(dequantized(numbers, floats({4}, {1, 2, 3, 4}), {}, {.axis = -1})),
              ElementsAre(1, 4, 9, 16, -5, -12, -21, -32));
  EXPECT_THAT(values(dequantized(numbers, floats({2, 2}, {1, 10, 100, 1000}),
                                 bytes({2, 2}, {0, 1, 0, -1}), {.axis = 1, .block_size = 2})),
              ElementsAre(1, 2, 20, 30, -500, -600, -6000, -7000));
  EXPECT_THAT(
      values(dequantized(numbers, floats({1, 4}, {1, 2, 3, 4}), {}, {.axis = 0, .block_size = 2})),
      ElementsAre(1, 4, 9, 16, -5, -12, -21, -32));
  EXPECT_THAT(values(dequantized(bytes({3}, {1, 2, 3}), floats({2}, {1, 10}), {},
                                 {.axis = 0, .block_size = 2})),
              ElementsAre(1, 2, 30));
}

TEST(OnnxTensor, RefusesScalesThatDoNotFit) {
  const OnnxTensor numbers = bytes({2, 4}, {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_TRUE(is_refused(numbers, floats({3}, {1, 2, 3}), {}, "scales of the shape (3)"));
  EXPECT_TRUE(is_refused(numbers, floats({4}, {1, 2, 3, 4}), {.axis = 2}, "axis 2"));
  EXPECT_TRUE(
      is_refused(numbers, floats({1, 1}, {1}), {.axis = 1, .block_size = 2}, "blocks of 2"));
  EXPECT_TRUE(is_refused(numbers, floats({1}, {1}), {.axis = 1, .block_size = -2}, "no sense"));
  EXPECT_TRUE(is_refused(numbers, bytes({}, {1}), {}, "32-bit floats"));
  EXPECT_TRUE(is_refused(floats({1}, {1}), floats({}, {1}), {}, "8, 16 or 32-bit"));
}

TEST(OnnxTensor, ReshapesAsOnnxDoes) {
  const OnnxTensor numbers = bytes({2, 6}, std::vector<std::int8_t>(12));
  EXPECT_THAT(reshaped(numbers, shape({2, 3, 2})).dims, ElementsAre(2, 3, 2));
  EXPECT_THAT(reshaped(numbers, shape({0, -1, 3})).dims, ElementsAre(2, 2, 3));
  for (const auto& sides :
       std::vector<std::vector<std::int64_t>>{{5, 2}, {-1, -1}, {-2, 6}, {-1, 5}, {12, 0, 1, 0}})
    EXPECT_TRUE(fails_with(ErrorCode::kModel, {}, [&] { (void)reshaped(numbers, shape(sides)); }));
}

TEST(OnnxTensor, ReadsBackWhatItWrites) {
  const OnnxTensor tensor = floats({1, 2, 1}, {3, 4});
  const OnnxTensor copy = onnx_tensor(encoded(tensor, "name"));
  EXPECT_EQ(copy.dims, tensor.dims);
  EXPECT_EQ(copy.data, tensor.data);
  EXPECT_EQ(onnx_tensor_name(encoded(tensor, "name")), "name");
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"tensor 'name': ", "(2, 2)", "8 bytes"}, [] {
    (void)onnx_tensor(encoded(floats({2, 2}, {3, 4}), "name"));
  }));
}

// One node of the graph.
std::string node(const std::string& type, const std::vector<std::string>& inputs,
                 const std::string& output) {
  std::string message;
  for (const std::string& input : inputs) protobuf::append_bytes(message, 1, input);
  protobuf::append_bytes(message, 2, output);
  protobuf::append_bytes(message, 4, type);
  return message;
}

// The file with more at the end of its graph.
std::string with_more(const std::string& onnx, std::uint64_t number,
                      const std::vector<std::string>& messages) {
  std::string model;
  const auto fields = protobuf::fields_of(onnx);
  if (!fields) throw std::logic_error("no ONNX file");
  for (const protobuf::Field& field : *fields) {
    constexpr std::uint64_t kGraph = 7;
    if (field.number != kGraph) {
      model += field.encoded;
      continue;
    }
    std::string graph(field.content);
    for (const std::string& message : messages) protobuf::append_bytes(graph, number, message);
    protobuf::append_bytes(model, kGraph, graph);
  }
  return model;
}

TEST(PlainWeights, LeavesAPlainFileAlone) {
  EXPECT_EQ(with_plain_weights(test::tiny_model().weights, "file"), std::nullopt);
}

TEST(PlainWeights, TakesOutIdentities) {
  constexpr std::uint64_t kNode = 1;
  Model model = test::tiny_model();
  const std::string before = model.weights;
  model.weights = with_more(
      before, kNode, {node("Identity", {"luma"}, "luma2"), node("Identity", {"luma2"}, "luma3")});
  const auto plain = with_plain_weights(model.weights, "file");
  ASSERT_TRUE(plain);
  EXPECT_THAT(*plain, Not(HasSubstr("Identity")));
  const cv::Mat_<cv::Vec3b> image = test::bright_square();
  EXPECT_EQ(cv::norm(make_network_strength(model, image.size())->strength(image),
                     make_network_strength(test::tiny_model(), image.size())->strength(image)),
            0);
}

TEST(PlainWeights, RefusesATensorOfAnotherSizeThanItSays) {
  constexpr std::uint64_t kInitializer = 5, kDataLocation = 14;
  std::string message = encoded(floats({1}, {1}), "more");
  protobuf::append_varint(message, 1, 1000);  // one more side
  Model model = test::tiny_model();
  const std::string good = model.weights;
  model.weights = with_more(good, kInitializer, {message});
  EXPECT_TRUE(
      fails_with(ErrorCode::kModel,
                 {"tiny_edges.onnx: tensor 'more': it has the shape (1, 1000), but 4 bytes"}, [&] {
                   (void)make_network_strength(model, {64, 64});
                 }));
  message = encoded(floats({0}, {}), "far");
  protobuf::append_varint(message, kDataLocation, 1);
  model.weights = with_more(good, kInitializer, {message});
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"tensor 'far': its data are in another file"}, [&] {
    (void)make_network_strength(model, {64, 64});
  }));
}

TEST(PlainWeights, RefusesAGraphWithLooseEnds) {
  constexpr std::uint64_t kNode = 1, kInput = 11, kOutput = 12;
  const auto refuses = [](std::uint64_t field, const std::string& message,
                          const std::string& part) {
    const std::string onnx = with_more(test::tiny_model().weights, field, {message});
    return fails_with(ErrorCode::kModel, {"file: ", part},
                      [&] { (void)with_plain_weights(onnx, "file"); });
  };
  std::string value;
  protobuf::append_bytes(value, 1, "another");
  EXPECT_TRUE(
      refuses(kInput, value, "it has 2 inputs (another, bgr); one, the image, is expected"));
  EXPECT_TRUE(refuses(kOutput, value, "nothing gives its output 'another'"));
  EXPECT_TRUE(refuses(kNode, node("Conv", {"bgr", "another"}, "x"),
                      "its node Conv needs 'another', which nothing gives"));
}

TEST(PlainWeights, NamesWhatIsDamaged) {
  constexpr std::uint64_t kNode = 1;
  const std::string onnx = with_more(test::tiny_model().weights, kNode,
                                     {node("DequantizeLinear", {"luma", "slope"}, "x")});
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"file: weights 'x': ", "8, 16 or 32-bit"},
                         [&] { (void)with_plain_weights(onnx, "file"); }));
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"file: not an ONNX file"},
                         [] { (void)with_plain_weights("\x3a\x7f", "file"); }));
}

// The image of scripts/dexined_random.py.
cv::Mat_<cv::Vec3b> example_image() {
  cv::Mat_<cv::Vec3b> image(48, 80);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      for (int c = 0; c < 3; ++c) {
        const bool in_square = y >= 10 && y < 30 && x >= 20 && x < 60;
        image(y, x)[c] = static_cast<std::uint8_t>((3 * x + 5 * y + 40 * c + x * y % 17) % 128 +
                                                   (in_square ? 100 : 0));
      }
  return image;
}

cv::Mat_<float> answer_of_torch(cv::Size size) {
  constexpr std::size_t kHeader = 128;  // [bytes], of the .npy
  const std::string file = read_file(EDVO_SOURCE_DIR "/tests/data/narrow_dexined.npy");
  cv::Mat_<float> answer(size);
  if (file.size() != kHeader + answer.total() * sizeof(float)) throw std::runtime_error("size");
  std::memcpy(answer.data, file.data() + kHeader, file.size() - kHeader);
  return answer;
}

TEST(DexiNed, AnswersAsTorchDoesWithItsWeightsInBlocks) {
  const Model model = read_model(EDVO_SOURCE_DIR "/tests/data/narrow_dexined.toml");
  EXPECT_THAT(model.weights, HasSubstr("block_size"));
  const cv::Mat_<cv::Vec3b> image = example_image();
  const cv::Mat_<float> answer = make_network_strength(model, image.size())->strength(image);
  EXPECT_LT(cv::norm(answer, answer_of_torch(image.size()), cv::NORM_INF), 1e-4);
}

TEST(DexiNed, RunsInSizesThatAreNoMultipleOfItsStride) {
  const Model model = read_model(EDVO_SOURCE_DIR "/tests/data/narrow_dexined.toml");
  for (const cv::Size size : {cv::Size(81, 47), cv::Size(16, 16), cv::Size(33, 100)})
    EXPECT_EQ(make_network_strength(model, size)->strength({size, cv::Vec3b()}).size(), size);
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"too small", "16 px"}, [&] {
    (void)make_network_strength(model, {80, 15});
  }));
}

TEST(DexiNed, IsRefusedWhereverItsFileIsCutOff) {
  Model model = read_model(EDVO_SOURCE_DIR "/tests/data/narrow_dexined.toml");
  const std::string whole = model.weights;
  for (std::size_t length = 1; length < whole.size(); length += 1999) {
    model.weights = whole.substr(0, length);
    EXPECT_TRUE(fails_with(ErrorCode::kModel, {"narrow_dexined.onnx: "}, [&] {
      (void)make_network_strength(model, {32, 32});
    }));
  }
}

}  // namespace
}  // namespace edvo
