// SPDX-License-Identifier: MIT
#include "edvo/io/model_cache.hpp"

#include "edvo/core/sha256.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/model_file.hpp"
#include "support/error_matcher.hpp"
#include "support/http_server.hpp"
#include "support/temporary_folder.hpp"
#include "support/tiny_network.hpp"

#include <gmock/gmock.h>

#include <chrono>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::fails_with;
using test::HttpServer;
using ::testing::ElementsAre;

constexpr std::size_t kHalf = 100'000;  // [bytes]

std::string some_bytes() {
  std::string bytes(2 * kHalf, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i % 251);
  return bytes;
}

class PullModel : public testing::Test {
 protected:
  std::optional<fs::path> pull(int max_lost_frames = 5) const {
    return pull_model(
        model_, folder_,
        {.address = server_.url(), .max_lost_frames = max_lost_frames, .on_progress = progress_});
  }
  auto refuses(std::initializer_list<std::string> parts, int max_lost_frames = 5) const {
    return fails_with(ErrorCode::kModel, parts, [&] { (void)pull(max_lost_frames); });
  }
  std::size_t part_size() const {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(folder_ / "some.onnx.part", error);
    return error ? 0 : size;
  }
  bool is_empty() const { return !fs::exists(folder_) || fs::is_empty(folder_); }
  void expect_whole(const std::optional<fs::path>& description) const {
    ASSERT_TRUE(description);
    const Model model = read_model(*description);
    EXPECT_EQ(model.weights, body_);
    EXPECT_EQ(model.description.input.multiple_of, 16);
    EXPECT_EQ(part_size(), 0U);
  }

  std::string body_ = some_bytes(), hash_ = sha256(body_);
  KnownModel model_{.name = "some",
                    .addresses = {},
                    .bytes = static_cast<std::int64_t>(body_.size()),
                    .sha256 = hash_,
                    .licence = "MIT",
                    .source = "a test",
                    .usage = find_known_model("dexined")->usage};
  test::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path() / "cache" / "models";
  HttpServer server_{{.body = body_}};
  std::function<bool(std::int64_t)> progress_;
};

TEST_F(PullModel, FetchesOnceChecksAndDescribes) {
  std::int64_t last = 0;
  progress_ = [&last](std::int64_t done) {
    last = std::max(last, done);
    return true;
  };
  expect_whole(pull());
  EXPECT_EQ(last, model_.bytes);
  expect_whole(pull());
  EXPECT_THAT(server_.starts(), ElementsAre(0));
}

TEST_F(PullModel, GoesOnWhereItWasCutOff) {
  server_.behave({.body = body_, .hangs_up_after = kHalf});
  EXPECT_TRUE(
      refuses({server_.url(), "it ended after 100000 of 200000 bytes", "goes on", "--from"}));
  EXPECT_EQ(part_size(), kHalf);
  EXPECT_FALSE(fs::exists(folder_ / "some.toml"));
  server_.behave({.body = body_});
  expect_whole(pull());
  EXPECT_THAT(server_.starts(), ElementsAre(0, kHalf));
}

TEST_F(PullModel, StartsOverWhereTheServerCannotGoOn) {
  server_.behave({.body = body_, .hangs_up_after = kHalf});
  EXPECT_TRUE(refuses({"it ended after"}));
  server_.behave({.body = body_, .knows_ranges = false});
  expect_whole(pull());
  EXPECT_THAT(server_.starts(), ElementsAre(0, kHalf, 0));
}

TEST_F(PullModel, KeepsNothingOfAnotherHash) {
  server_.behave({.body = std::string(body_.size(), 'x')});
  EXPECT_TRUE(refuses({"not the model some", "its SHA-256 is", "instead of " + hash_, "not kept"}));
  EXPECT_TRUE(is_empty());
  server_.behave({.body = body_});
  expect_whole(pull());
}

TEST_F(PullModel, KeepsNothingThatContinuesAnotherFile) {
  temporary_.write("cache/models/some.onnx.part", std::string(kHalf, 'x'));
  EXPECT_TRUE(refuses({"not the model some", "starts anew"}));
  expect_whole(pull());
}

TEST_F(PullModel, TakesAPartThatIsWholeAndDropsOneThatIsTooLong) {
  temporary_.write("cache/models/some.onnx.part", body_);
  expect_whole(pull());
  EXPECT_THAT(server_.starts(), ElementsAre());
  fs::remove(folder_ / "some.onnx");
  temporary_.write("cache/models/some.onnx.part", body_ + "x");
  expect_whole(pull());
}

TEST_F(PullModel, RefusesMoreThanItAskedFor) {
  server_.behave({.body = body_ + body_});
  EXPECT_TRUE(refuses({"it sends more than the 200000 bytes"}));
}

TEST_F(PullModel, TellsAWebPageFromAModel) {
  server_.behave({.body = "version https://git-lfs.github.com/spec/v1\n"});
  EXPECT_TRUE(refuses({"it ended after 43 of 200000 bytes"}));
}

TEST_F(PullModel, SaysThatTheServerHasNoSuchFile) {
  server_.behave({.body = "", .status = 404});
  EXPECT_TRUE(refuses({server_.url(), "the server answers 404, no such file", "--url"}));
  EXPECT_TRUE(is_empty());
}

TEST_F(PullModel, DoesNotWaitForEver) {
  server_.behave({.body = body_, .stalls_after = kHalf});
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(refuses({"for 1 s; 100000 of 200000 bytes are here"}, 1));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(8));
  server_.behave({.body = body_});
  expect_whole(pull());
}

TEST_F(PullModel, StopsWhenAskedAndKeepsWhatIsThere) {
  progress_ = [](std::int64_t done) { return done == 0; };
  server_.behave({.body = body_, .stalls_after = kHalf});
  EXPECT_EQ(pull(), std::nullopt);
  EXPECT_GT(part_size(), 0U);
  progress_ = nullptr;
  server_.behave({.body = body_});
  expect_whole(pull());
}

TEST_F(PullModel, TriesTheNextAddress) {
  const std::array<std::string_view, 2> addresses = {"http://127.0.0.1:1/model.onnx", ""};
  std::array<std::string_view, 2> both = addresses;
  const std::string second = server_.url();
  both[1] = second;
  model_.addresses = both;
  std::vector<std::string> notes;
  expect_whole(pull_model(
      model_, folder_,
      {.max_lost_frames = 5, .on_note = [&](const std::string& note) { notes.push_back(note); }}));
  EXPECT_THAT(notes, ElementsAre("from http://127.0.0.1:1/model.onnx",
                                 ::testing::HasSubstr("cannot be downloaded"), "from " + second));
}

TEST_F(PullModel, SaysSoOffline) {
  const auto offline = [&](const std::string& address) {
    return fails_with(ErrorCode::kModel, {address, "check the network", "--from FILE"}, [&] {
      (void)pull_model(model_, folder_, {.address = address, .max_lost_frames = 5});
    });
  };
  EXPECT_TRUE(offline("http://127.0.0.1:1/model.onnx"));
  EXPECT_TRUE(offline("http://no.such.host.invalid/model.onnx"));
  EXPECT_TRUE(offline("file:///etc/hostname"));
  EXPECT_TRUE(is_empty());
}

TEST_F(PullModel, TakesAFileWithoutNetwork) {
  const fs::path file = temporary_.write("here.onnx", body_);
  expect_whole(pull_model_from(model_, folder_, file));
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"other.onnx: not the model some: 1 bytes"}, [&] {
    (void)pull_model_from(model_, folder_, temporary_.write("other.onnx", "x"));
  }));
  EXPECT_TRUE(fails_with(ErrorCode::kModel, {"none.onnx: no such file"},
                         [&] { (void)pull_model_from(model_, folder_, "none.onnx"); }));
  EXPECT_THAT(server_.starts(), ElementsAre());
}

TEST_F(PullModel, RepairsADamagedFile) {
  expect_whole(pull());
  temporary_.write("cache/models/some.onnx", "damaged");
  expect_whole(pull());
}

TEST_F(PullModel, SaysThatTheCacheCannotBeWritten) {
  folder_ = "/proc/nowhere";
  EXPECT_TRUE(
      fails_with(ErrorCode::kOutput, {"/proc/nowhere", "XDG_CACHE_HOME"}, [&] { (void)pull(); }));
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
