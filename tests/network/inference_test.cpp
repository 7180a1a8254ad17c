// SPDX-License-Identifier: MIT
#include "edvo/network/inference.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/model_file.hpp"
#include "edvo/network/edge_network.hpp"
#include "edvo/network/onnx_fields.hpp"
#include "edvo/network/onnx_tensor.hpp"
#include "edvo/network/protobuf.hpp"
#include "support/error_matcher.hpp"
#include "support/tiny_network.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <opencv2/core/utility.hpp>

namespace edvo {
namespace {

using test::fails_with;
using test::patched;

Model model_of_tests(const std::string& name) {
  return read_model(EDVO_SOURCE_DIR "/tests/data/" + name + ".toml");
}

// Random squares on noise.
cv::Mat_<cv::Vec3b> image_of(cv::Size size) {
  cv::RNG random(7);
  cv::Mat_<cv::Vec3b> image(size);
  random.fill(image, cv::RNG::UNIFORM, 80, 120);
  for (int i = 0; i < 10; ++i) {
    const cv::Rect square(random.uniform(0, size.width), random.uniform(0, size.height), 20, 15);
    image(square & cv::Rect({}, size)) += cv::Scalar::all(random.uniform(20, 120));
  }
  return image;
}

cv::Mat_<float> answer(const Model& model, const cv::Mat_<cv::Vec3b>& image,
                       InferenceEngine engine) {
  return make_network_strength(model, image.size(), engine)->strength(image);
}

TEST(Inference, GivesTheSameEdgesWithBothEngines) {
  std::vector<Model> models = {own_model()};
  // OpenCV 4.10 does not find the sizes of their Concat for an input of any size.
  if (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR < 10)
    for (const char* const name : {"narrow_dexined", "operators"})
      models.push_back(model_of_tests(name));
  for (const Model& model : models)
    for (const cv::Size size : {cv::Size(96, 64), cv::Size(173, 99), cv::Size(16, 16)}) {
      const cv::Mat_<cv::Vec3b> image = image_of(size);
      const cv::Mat_<float> expected = answer(model, image, InferenceEngine::kOpenCv);
      double lowest = 0, highest = 0;
      cv::minMaxLoc(expected, &lowest, &highest);
      EXPECT_GT(highest - lowest, 0.2) << "nothing to compare: " << model.source;
      EXPECT_LT(cv::norm(answer(model, image, InferenceEngine::kOneDnn), expected, cv::NORM_INF),
                1e-4)
          << model.source << ' ' << size;
    }
}

OnnxTensor random_weights(std::vector<std::int64_t> dims) {
  std::int64_t count = 1;
  for (const std::int64_t side : dims) count *= side;
  const double sigma = std::sqrt(2.0 * static_cast<double>(dims[0]) / static_cast<double>(count));
  cv::Mat_<float> numbers(1, static_cast<int>(count));
  cv::RNG(static_cast<std::uint64_t>(count)).fill(numbers, cv::RNG::NORMAL, 0, sigma);
  return {.dims = std::move(dims),
          .type = OnnxType::kFloat,
          .data = {reinterpret_cast<const char*>(numbers.data), numbers.total() * sizeof(float)}};
}

// Two 3 x 3 convolutions of 64 channels, with more border and with less, added to their input.
std::string wide_residual() {
  using namespace onnx_field;
  std::string graph;
  const auto sides = [](std::string_view name, int count, int value) {
    std::string attribute;
    protobuf::append_bytes(attribute, kAttributeName, name);
    for (int side = 0; side < count; ++side)
      protobuf::append_varint(attribute, kAttributeIntegers, static_cast<std::uint64_t>(value));
    return attribute;
  };
  const auto node = [&](std::string_view type, const std::vector<std::string>& inputs,
                        std::string_view output, int kernel = 0, int border = 0) {
    std::string message;
    for (const std::string& input : inputs) protobuf::append_bytes(message, kNodeInput, input);
    protobuf::append_bytes(message, kNodeOutput, output);
    protobuf::append_bytes(message, kNodeType, type);
    if (kernel > 0) {
      protobuf::append_bytes(message, kNodeAttribute, sides("kernel_shape", 2, kernel));
      protobuf::append_bytes(message, kNodeAttribute, sides("pads", 4, border));
    }
    protobuf::append_bytes(graph, kGraphNode, message);
  };
  const auto weights = [&graph](std::string_view name, std::vector<std::int64_t> dims) {
    protobuf::append_bytes(graph, kGraphInitializer,
                           encoded(random_weights(std::move(dims)), name));
  };
  node("Conv", {"image", "spread"}, "wide", 1);
  node("Conv", {"wide", "first"}, "larger", 3, 2);
  node("Relu", {"larger"}, "that nobody asks for");
  node("Relu", {"larger"}, "positive");
  node("Conv", {"positive", "second"}, "again", 3);
  node("Add", {"again", "wide"}, "sum");
  node("Conv", {"sum", "gather"}, "logits", 1);
  node("Sigmoid", {"logits"}, "edges");
  weights("spread", {64, 3, 1, 1});
  weights("first", {64, 64, 3, 3});
  weights("second", {64, 64, 3, 3});
  weights("gather", {1, 64, 1, 1});
  for (const auto& [field, name] : {std::pair(kGraphInput, "image"), {kGraphOutput, "edges"}}) {
    // Of floats, 1 x 3 x 64 x 96: OpenCV wants to be told.
    std::string value, type, tensor, shape;
    for (const std::uint64_t side : {1, 3, 64, 96}) {
      std::string dimension;
      protobuf::append_varint(dimension, 1, side);
      protobuf::append_bytes(shape, 1, dimension);
    }
    protobuf::append_varint(tensor, 1, 1);
    protobuf::append_bytes(tensor, 2, shape);
    protobuf::append_bytes(type, 1, tensor);
    protobuf::append_bytes(value, kValueName, name);
    protobuf::append_bytes(value, 2, type);
    protobuf::append_bytes(graph, field, value);
  }
  std::string model;
  protobuf::append_bytes(model, kModelGraph, graph);
  constexpr std::uint64_t kFormat = 1, kOperatorSet = 8, kVersion = 2;
  protobuf::append_varint(model, kFormat, 7);
  std::string operators;
  protobuf::append_varint(operators, kVersion, 11);
  protobuf::append_bytes(model, kOperatorSet, operators);
  return model;
}

TEST(Inference, GivesTheSameEdgesWhereOneDnnTransformsTheImage) {
  Model model = model_of_tests("operators");
  model.weights = wide_residual();
  model.description.input.scale = 1.0 / 255;
  const cv::Mat_<cv::Vec3b> image = image_of({96, 64});
  const cv::Mat_<float> expected = answer(model, image, InferenceEngine::kOpenCv);
  const cv::Mat_<float> found = answer(model, image, InferenceEngine::kOneDnn);
  double lowest = 0, highest = 0;
  cv::minMaxLoc(expected, &lowest, &highest);
  EXPECT_GT(highest - lowest, 0.2);
  EXPECT_LT(cv::norm(found, expected, cv::NORM_INF), 1e-4);
}

TEST(Inference, GivesTheSameBitsTwiceAndWithAnyNumberOfThreads) {
  const int threads = cv::getNumThreads();
  const cv::Mat_<cv::Vec3b> image = image_of({640, 480});
  for (const Model& model : {own_model(), model_of_tests("operators")}) {
    cv::setNumThreads(1);
    const cv::Mat_<float> first = answer(model, image, InferenceEngine::kOneDnn);
    for (const int count : {1, 2, 3}) {
      cv::setNumThreads(count);
      const cv::Mat_<float> again = answer(model, image, InferenceEngine::kOneDnn);
      EXPECT_TRUE(std::equal(first.begin(), first.end(), again.begin())) << count << " threads";
    }
  }
  cv::setNumThreads(threads);
}

TEST(Inference, FollowsTheImageToAnotherSizeAndBack) {
  const auto detector = make_network_strength(own_model(), {96, 64}, InferenceEngine::kOneDnn);
  const cv::Mat_<cv::Vec3b> small = image_of({96, 64}), large = image_of({128, 120});
  const cv::Mat_<float> first = detector->strength(small);
  EXPECT_EQ(cv::norm(detector->strength(large),
                     answer(own_model(), large, InferenceEngine::kOneDnn), cv::NORM_INF),
            0);
  EXPECT_EQ(cv::norm(detector->strength(small), first, cv::NORM_INF), 0);
}

TEST(Inference, GoesToOpenCvWhereOneDnnLacksAnOperator) {
  const Model model = test::tiny_model();
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"tiny_edges.onnx: oneDNN ", "the operator Pad"}, [&] {
    (void)answer(model, image_of({64, 48}), InferenceEngine::kOneDnn);
  }));
  EXPECT_EQ(cv::norm(answer(model, image_of({64, 48}), InferenceEngine::kAuto),
                     answer(model, image_of({64, 48}), InferenceEngine::kOpenCv)),
            0);
}

TEST(Inference, RefusesAGraphThatDoesNotFitTogether) {
  const Model good = model_of_tests("operators");
  const auto refuses = [&](const std::string& from, const std::string& to) {
    Model bad = good;
    bad.weights = patched(good.weights, from, to);
    return fails_with(ErrorCode::kModel, {"operators.onnx: "}, [&] {
      (void)answer(bad, image_of({64, 48}), InferenceEngine::kOneDnn);
    });
  };
  EXPECT_TRUE(refuses("MaxPool", "MinPool"));
  EXPECT_TRUE(refuses("linear", "nearer"));
  EXPECT_TRUE(refuses("half_pixel", "half_metre"));
  EXPECT_TRUE(refuses("group", "gruop"));
}

}  // namespace
}  // namespace edvo
