// SPDX-License-Identifier: MIT
#include "edvo/io/model_cache.hpp"

#include "edvo/core/sha256.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/model_file.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"
#include "support/tiny_network.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <optional>
#include <span>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::fails_with;
using ::testing::ElementsAre;

class ImportKnownModel : public testing::Test {
 protected:
  [[nodiscard]] std::optional<fs::path> import(const fs::path& file) const {
    return import_known_model(file, folder_, std::span(&model_, 1));
  }
  void expect_whole(const std::optional<fs::path>& description) const {
    ASSERT_TRUE(description);
    EXPECT_EQ(*description, folder_ / "some.toml");
    const Model model = read_model(*description);
    EXPECT_EQ(model.weights, body_);
    EXPECT_EQ(model.description.input.multiple_of, 16);
  }

  std::string body_ = "the weights of a model", hash_ = sha256(body_);
  KnownModel model_{.name = "some",
                    .addresses = {},
                    .bytes = static_cast<std::int64_t>(body_.size()),
                    .sha256 = hash_,
                    .licence = "MIT",
                    .source = "a test",
                    .usage = find_known_model("dexined")->usage};
  test::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path() / "cache" / "models";
};

TEST_F(ImportKnownModel, KnowsItBySizeAndHashAndDescribesIt) {
  expect_whole(import(temporary_.write("any name", body_)));
}

TEST_F(ImportKnownModel, LeavesOtherFilesAlone) {
  EXPECT_EQ(import(temporary_.write("longer", body_ + "x")), std::nullopt);
  EXPECT_EQ(import(temporary_.write("same size", std::string(body_.size(), 'x'))), std::nullopt);
  EXPECT_EQ(import("none.onnx"), std::nullopt);
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(ImportKnownModel, TakesAFileThatLiesInItsPlace) {
  expect_whole(import(temporary_.write("cache/models/some.onnx", body_)));
}

TEST_F(ImportKnownModel, RepairsADamagedFile) {
  temporary_.write("cache/models/some.onnx", "damaged");
  expect_whole(import(temporary_.write("again", body_)));
}

TEST_F(ImportKnownModel, SaysThatTheCacheCannotBeWritten) {
  folder_ = "/proc/nowhere";
  EXPECT_TRUE(fails_with(ErrorCode::kOutput, {"/proc/nowhere", "XDG_CACHE_HOME"},
                         [&] { (void)import(temporary_.write("here", body_)); }));
}

TEST(ModelCatalogue, HasDescriptionsThatCanBeRead) {
  for (const KnownModel& model : known_models()) {
    const std::string text = "file = 'x'\n" + std::string(model.usage);
    const ModelDescription description = model_description_from_toml(text, std::string(model.name));
    EXPECT_EQ(description.output.activation, Activation::kSigmoid);
    EXPECT_EQ(model.sha256.size(), 64U);
    EXPECT_FALSE(model.addresses.empty());
  }
  EXPECT_EQ(find_known_model("none"), nullptr);
}

class ImportModel : public testing::Test {
 protected:
  auto import(bool replace = false) const {
    return import_model(description_, onnx_, folder_, replace);
  }
  auto refuses(std::initializer_list<std::string> parts) const {
    return fails_with(ErrorCode::kModel, parts, [&] { (void)import(); });
  }

  test::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path() / "models";
  fs::path description_ = test::kTinyModel;
  fs::path onnx_ = fs::path(test::kTinyModel).replace_extension(".onnx");
};

TEST_F(ImportModel, KeepsTheNetworkUnderItsName) {
  const fs::path description = import();
  EXPECT_EQ(description, folder_ / "tiny_edges.toml");
  EXPECT_EQ(find_cached_model(folder_, "tiny_edges"), description);
  EXPECT_THAT(cached_models(folder_), ElementsAre("tiny_edges"));
  const Model copy = read_model(description), original = test::tiny_model();
  EXPECT_EQ(copy.weights, original.weights);
  EXPECT_EQ(to_toml(copy.description), to_toml(original.description));
}

TEST_F(ImportModel, ReplacesOnlyWhenAsked) {
  (void)import();
  EXPECT_TRUE(refuses({"there is a model 'tiny_edges' already", "--force"}));
  EXPECT_NO_THROW((void)import(true));
}

TEST_F(ImportModel, AddsNameAndHashWhereTheyAreMissing) {
  description_ = temporary_.write("plain.toml", "file = 'elsewhere.onnx'");
  onnx_ = temporary_.write("own.onnx", "weights");
  const Model model = read_model(import());
  EXPECT_EQ(model.description.name, "own");
  EXPECT_EQ(model.description.sha256, sha256("weights"));
}

TEST_F(ImportModel, RefusesNamesThatWouldDoHarm) {
  onnx_ = temporary_.write("own.onnx", "weights");
  for (const char* name : {"../up", "a/b", ".hidden", "-f", "two words"}) {
    description_ = temporary_.write("d.toml", fmt::format("name = '{}'\nfile = 'x'", name));
    EXPECT_TRUE(refuses({"d.toml", name, "is no file name"}));
  }
  description_ = temporary_.write("d.toml", "name = 'dexined'\nfile = 'x'");
  EXPECT_TRUE(refuses({"belongs to a known model"}));
  description_ =
      temporary_.write("d.toml", "name = 'n'\nfile = 'x'\nsha256 = '" + sha256("y") + "'");
  EXPECT_TRUE(refuses({"own.onnx: its SHA-256 is " + sha256("weights")}));
}

TEST(ModelDescription, ReadsBackWhatItWrites) {
  ModelDescription model = test::tiny_model().description;
  const auto survives = [&] {
    const std::string text = to_toml(model);
    EXPECT_EQ(to_toml(model_description_from_toml(text, "copy")), text);
  };
  survives();
  model.source = "quotes \" and ' and \\ and\nlines";
  model.input = {.channels = ChannelOrder::kRgb,
                 .mean = {103.939, 0.1, -3},
                 .scale = 1 / 255.0,
                 .padding = Padding::kReplicate,
                 .size = {512, 512}};
  model.output = {.name = "fused \"one\"", .index = -1, .activation = Activation::kNone};
  survives();
  EXPECT_EQ(model_description_from_toml(to_toml(model), "copy").input.mean, model.input.mean);
  EXPECT_EQ(model_description_from_toml(to_toml(model), "copy").source, model.source);
}

}  // namespace
}  // namespace edvo
