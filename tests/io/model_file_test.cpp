// SPDX-License-Identifier: MIT
#include "edvo/io/model_file.hpp"

#include "edvo/core/sha256.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"
#include "support/tiny_network.hpp"

#include <gtest/gtest.h>

namespace edvo {
namespace {

using test::fails_with;

testing::AssertionResult is_refused(const std::string& toml,
                                    std::initializer_list<std::string> parts) {
  return fails_with(ErrorCode::kModel, parts,
                    [&] { (void)model_description_from_toml(toml, "my.toml"); });
}

TEST(ModelDescription, ReadsEveryKey) {
  const ModelDescription model = model_description_from_toml(R"(
name = "n"
file = "n.onnx"
sha256 = "E3B0C44298FC1C149AFBF4C8996FB92427AE41E4649B934CA495991B7852B855"
licence = "MIT"
source = "us"
[input]
channels = "rgb"
mean = [103.939, 116.779, 123]
scale = 2
multiple_of = 16
padding = "replicate"
factor = 0.5
[output]
index = 3
activation = "sigmoid"
)",
                                                             "my.toml");
  EXPECT_EQ(model.name, "n");
  EXPECT_EQ(model.file, "n.onnx");
  EXPECT_EQ(model.sha256, sha256(""));
  EXPECT_EQ(model.licence, "MIT");
  EXPECT_EQ(model.source, "us");
  EXPECT_EQ(model.input.channels, ChannelOrder::kRgb);
  EXPECT_EQ(model.input.mean, (std::array{103.939, 116.779, 123.0}));
  EXPECT_EQ(model.input.scale, 2);
  EXPECT_EQ(model.input.multiple_of, 16);
  EXPECT_EQ(model.input.padding, Padding::kReplicate);
  EXPECT_EQ(model.input.factor, 0.5);
  EXPECT_EQ(model.output.index, 3);
  EXPECT_EQ(model.output.activation, Activation::kSigmoid);
  const auto other = model_description_from_toml(
      "file = 'n.onnx'\ninput.size = [640, 480]\noutput.name = 'fused'", "my.toml");
  EXPECT_EQ(other.input.size, cv::Size(640, 480));
  EXPECT_EQ(other.output.name, "fused");
}

TEST(ModelDescription, NamesFileLineAndKeyOfWhatIsWrong) {
  EXPECT_TRUE(is_refused("file = 'a'\n[input]\nmaen = [1, 2, 3]",
                         {"my.toml:3: unknown key 'input.maen', did you mean 'mean'?"}));
  EXPECT_TRUE(is_refused("file = 'a'\nhash = ''", {"my.toml:2: unknown key 'hash'"}));
  EXPECT_TRUE(is_refused("file = 3", {"my.toml:1: file: expected text"}));
  EXPECT_TRUE(is_refused("name = 'n'", {"my.toml: file is missing"}));
  EXPECT_TRUE(is_refused("input = 3", {"input: expected a table"}));
  EXPECT_TRUE(is_refused("input.mean = [1, 2]", {"input.mean: expected 3 numbers"}));
  EXPECT_TRUE(is_refused("input.mean = [1, 2, 'x']", {"input.mean: expected a number"}));
  EXPECT_TRUE(is_refused("input.scale = nan", {"input.scale: nan is out of range"}));
  EXPECT_TRUE(is_refused("input.scale = 0", {"input.scale: 0 is out of range"}));
  EXPECT_TRUE(is_refused("input.multiple_of = 1.5", {"input.multiple_of: expected a whole"}));
  EXPECT_TRUE(is_refused("input.multiple_of = 0", {"input.multiple_of: 0 is out of range"}));
  EXPECT_TRUE(is_refused("input.channels = 'brg'", {"'brg'", "did you mean 'bgr'?"}));
  EXPECT_TRUE(is_refused("output.activation = 'relu'", {"'relu'", "allowed: none, sigmoid"}));
  EXPECT_TRUE(is_refused("output.index = -2", {"output.index: -2 is out of range"}));
  EXPECT_TRUE(is_refused("input.size = [64, 64]\ninput.factor = 2", {"my.toml:2", "leave one"}));
  EXPECT_TRUE(is_refused("output.name = 'a'\noutput.index = 2", {"my.toml:2", "leave one"}));
  EXPECT_TRUE(is_refused("file = 'a'\nsha256 = 'abc'", {"my.toml:2: sha256", "64 hexadecimal"}));
  EXPECT_TRUE(is_refused("a b", {"my.toml:1: ", "TOML"}));
}

TEST(ModelFile, ReadsTheNetworkBesideItsDescription) {
  const Model model = test::tiny_model();
  EXPECT_EQ(model.description.name, "tiny_edges");
  EXPECT_EQ(sha256(model.weights), model.description.sha256);
}

TEST(ModelFile, SaysWhichFileIsMissingOrChanged) {
  const test::TemporaryFolder folder;
  const auto refuses = [](const std::filesystem::path& path,
                          std::initializer_list<std::string> parts) {
    return fails_with(ErrorCode::kModel, parts, [&] { (void)read_model(path); });
  };
  EXPECT_TRUE(refuses(folder.path() / "none.toml", {"none.toml: no such file"}));
  EXPECT_TRUE(refuses(folder.path(), {"not a regular file"}));
  EXPECT_TRUE(refuses(folder.write("a.toml", "file = 'a.onnx'"), {"a.onnx: no such file"}));
  EXPECT_TRUE(refuses(folder.write("a.onnx", "x"), {"a.onnx: ", "by its description"}));
  EXPECT_TRUE(refuses(folder.write("b.toml", "file = 'a.onnx'\nsha256 = '" + sha256("y") + "'"),
                      {"a.onnx: its SHA-256 is " + sha256("x"), "b.toml expects " + sha256("y")}));
}

TEST(ModelDescription, WithoutAChecksumItIsWrittenSoThatItCanBeReadAgain) {
  const ModelDescription model{.file = "a.onnx"};
  const ModelDescription again = model_description_from_toml(to_toml(model), "again");
  EXPECT_EQ(again.sha256, "");
  EXPECT_EQ(to_toml(again), to_toml(model));
}

}  // namespace
}  // namespace edvo
