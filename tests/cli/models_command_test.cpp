// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/io/image_file.hpp"
#include "support/program.hpp"
#include "support/sliding_sequence.hpp"
#include "support/temporary_folder.hpp"
#include "support/tiny_network.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ModelsCommand : public testing::Test {
 protected:
  void SetUp() override { setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1); }
  void TearDown() override { unsetenv("XDG_CACHE_HOME"); }

  static auto run(const std::string& arguments) {
    return test::run_edvo("models " + arguments + " 2>&1");
  }
  static void expect_refused(const std::string& arguments, ErrorCode code,
                             const std::string& part) {
    const auto result = run(arguments);
    EXPECT_EQ(result.status, static_cast<int>(code)) << result.output;
    EXPECT_THAT(result.output, HasSubstr(part));
  }
  [[nodiscard]] std::string description(const std::string& name) const {
    return (folder_.path() / "edvo/models" / (name + ".toml")).string();
  }

  test::TemporaryFolder folder_;
  std::string tiny_ = fs::path(test::kTinyModel).replace_extension(".onnx").string();
};

TEST_F(ModelsCommand, ImportsListsFindsAndVerifies) {
  ASSERT_EQ(run("import " + tiny_).output, description("tiny_edges") + "\n");
  EXPECT_EQ(run("path tiny_edges").output, description("tiny_edges") + "\n");
  EXPECT_THAT(run("list").output, AllOf(HasSubstr("dexined          not there      47.2 MB  MIT"),
                                        HasSubstr("tiny_edges       ready")));
  const auto json = nlohmann::json::parse(run("list --json").output);
  EXPECT_EQ(json["models"][0]["bytes"], 47'235'563);
  EXPECT_EQ(json["models"][1]["state"], "ready");
  EXPECT_EQ(run("verify").output, "tiny_edges: ok\n");
  std::ofstream(folder_.path() / "edvo/models/tiny_edges.onnx", std::ios::app) << "x";
  expect_refused("verify", ErrorCode::kModel, "import it again with --force");
  expect_refused("import " + tiny_, ErrorCode::kModel, "--force");
  EXPECT_EQ(run("import --force " + tiny_).status, 0);
  EXPECT_EQ(run("verify tiny_edges").status, 0);
}

TEST_F(ModelsCommand, LetsModelsBeNamed) {
  ASSERT_EQ(run("import " + tiny_).status, 0);
  const fs::path image = folder_.path() / "a.png", edges = folder_.path() / "edges.png";
  write_png(image, test::bright_square());
  const auto detect = [&](const std::string& model) {
    return test::run_edvo("edges " + image.string() + " -o " + edges.string() + " --model " +
                          model + " 2>&1");
  };
  EXPECT_EQ(detect("tiny_edges").status, 0);
  EXPECT_GT(cv::countNonZero(read_colour(edges).reshape(1)), 0);
  const auto absent = detect("dexined");
  EXPECT_EQ(absent.status, static_cast<int>(ErrorCode::kModel));
  EXPECT_THAT(absent.output, HasSubstr("edvo pull dexined"));
}

TEST_F(ModelsCommand, RefusesWhatCannotRunBeforeItIsKept) {
  const std::string own = folder_.write("own.onnx", "no network").string();
  expect_refused("import " + own, ErrorCode::kModel, "own.toml: no such file");
  folder_.write("own.toml", "file = 'own.onnx'");
  expect_refused("import " + own, ErrorCode::kModel, "own.onnx: not an ONNX file");
  EXPECT_FALSE(fs::exists(description("own")));
}

TEST_F(ModelsCommand, SaysHowToGetDexined) {
  expect_refused("path dexined", ErrorCode::kModel, "edvo pull dexined");
  expect_refused("path dexined", ErrorCode::kModel, "edvo models import FILE");
  const std::string other = folder_.write("other.onnx", "something else").string();
  expect_refused("import " + other, ErrorCode::kModel, "is no model that edvo knows");
}

TEST_F(ModelsCommand, ExplainsItself) {
  expect_refused("", ErrorCode::kUsage, "models needs a verb (known: list, verify, import, path)");
  expect_refused("verfy dexined", ErrorCode::kUsage,
                 "unknown verb 'models verfy', did you mean 'verify'?");
  expect_refused("import x.onnx --forse", ErrorCode::kUsage, "did you mean '--force'?");
  expect_refused("path nothing", ErrorCode::kModel, "there is no model nothing; there are: none");
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class EdgeCacheOption : public testing::Test {
 protected:
  void SetUp() override { test::write_sliding_sequence(sequence_); }
  auto run(const std::string& out, const std::string& arguments) const {
    return test::run_edvo("run " + sequence_.string() + " --no-report --model " +
                          test::kTinyModel.string() + " -o " + (folder_.path() / out).string() +
                          " " + arguments + " 2>&1");
  }
  [[nodiscard]] std::string trajectory(const std::string& out) const {
    return text_of(folder_.path() / out / "trajectory.tum");
  }

  test::TemporaryFolder folder_;
  fs::path sequence_ = folder_.path() / "sliding", cache_ = folder_.path() / "cache";
  std::string option_ = "--edge-cache " + cache_.string();
};

TEST_F(EdgeCacheOption, ChangesNoBitOfTheTrajectory) {
  ASSERT_EQ(run("without", "").status, 0);
  ASSERT_EQ(run("first", option_).status, 0);
  const auto entries = std::distance(fs::directory_iterator(cache_), fs::directory_iterator());
  EXPECT_GT(entries, 0);
  ASSERT_EQ(run("second", option_).status, 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(cache_), fs::directory_iterator()), entries);
  EXPECT_EQ(trajectory("first"), trajectory("without"));
  EXPECT_EQ(trajectory("second"), trajectory("without"));

  for (const fs::directory_entry& entry : fs::directory_iterator(cache_))
    fs::resize_file(entry.path(), 100);
  const auto damaged = run("third", option_);
  EXPECT_EQ(damaged.status, 0);
  EXPECT_THAT(damaged.output, HasSubstr("warning: " + cache_.string()));
  EXPECT_EQ(trajectory("third"), trajectory("without"));
}

TEST_F(EdgeCacheOption, IsRefusedWhereItMakesNoSense) {
  const auto canny = test::run_edvo("run " + sequence_.string() + " -o " +
                                    (folder_.path() / "out").string() + " " + option_ + " 2>&1");
  EXPECT_EQ(canny.status, static_cast<int>(ErrorCode::kUsage)) << canny.output;
  EXPECT_THAT(canny.output, HasSubstr("uses no network"));
  const auto nowhere = run("out", "--edge-cache /proc/nowhere");
  EXPECT_EQ(nowhere.status, static_cast<int>(ErrorCode::kOutput)) << nowhere.output;
  EXPECT_FALSE(fs::exists(folder_.path() / "out"));
}

}  // namespace
}  // namespace edvo
