// SPDX-License-Identifier: MIT
// What files, names, limits and signals may do to the program: it says what is wrong, by its own
// exit status, and nothing else.
#include "edvo/core/error.hpp"
#include "support/program.hpp"
#include "support/sliding_sequence.hpp"
#include "support/small_sequence.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::ProgramResult;
using test::run_edvo;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int status_of(ErrorCode code) {
  return static_cast<int>(code);
}

// The program within a shell that sets things up first.
ProgramResult run_after(const std::string& preparation, const std::string& arguments) {
  return run_edvo("--version >/dev/null; " + preparation + "; " + EDVO_PROGRAM + " " + arguments);
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class HostileInput : public testing::Test {
 protected:
  [[nodiscard]] std::string place(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  test::TemporaryFolder folder_;
};

TEST_F(HostileInput, KeysOfFortyThousandPartsAreRefusedByEveryReaderOfToml) {
  std::string key = "a";
  for (int i = 0; i < 40'000; ++i) key += ".a";
  folder_.write("deep.toml", key + " = 1\n");
  test::write_sliding_sequence(folder_.path() / "sequence");
  const std::string deep = place("deep.toml");
  const auto refuses = [](const std::string& arguments, ErrorCode code) {
    const ProgramResult result = run_edvo(arguments + " 2>&1");
    EXPECT_EQ(result.status, status_of(code)) << arguments << ": " << result.output;
    EXPECT_THAT(result.output, HasSubstr("nested too deeply")) << arguments;
  };
  refuses("config --config " + deep, ErrorCode::kConfig);
  refuses("bench " + deep, ErrorCode::kConfig);
  refuses("run " + place("sequence") + " --camera " + deep, ErrorCode::kCalibration);
  refuses("run " + place("sequence") + " --model " + deep, ErrorCode::kModel);
}

// toml++ asserts before it checks (core/toml.hpp).
TEST_F(HostileInput, ATableWithoutANameIsRefusedByEveryReaderOfToml) {
  folder_.write("dots.toml", "[....");
  test::write_sliding_sequence(folder_.path() / "sequence");
  const auto status = [](const std::string& arguments) { return run_edvo(arguments).status; };
  const std::string dots = place("dots.toml") + " 2>/dev/null";
  EXPECT_EQ(status("config --config " + dots), status_of(ErrorCode::kConfig));
  EXPECT_EQ(status("bench " + dots), status_of(ErrorCode::kConfig));
  EXPECT_EQ(status("run " + place("sequence") + " --camera " + dots),
            status_of(ErrorCode::kCalibration));
  EXPECT_EQ(status("run " + place("sequence") + " --model " + dots), status_of(ErrorCode::kModel));
}

TEST_F(HostileInput, AConfigurationWithoutEndIsRefused) {
  const ProgramResult zeros = run_edvo("config --config /dev/zero 2>&1");
  EXPECT_EQ(zeros.status, status_of(ErrorCode::kConfig));
  EXPECT_THAT(zeros.output, HasSubstr("too large"));
  EXPECT_EQ(run_edvo("config --config " + place("") + " 2>&1").status,
            status_of(ErrorCode::kConfig));
}

TEST_F(HostileInput, OutputThatCannotBeWrittenIsAnError) {
  for (const char* const arguments : {"config", "models list", "--help", "--version", "cache"}) {
    const ProgramResult result = run_edvo(std::string(arguments) + " 2>&1 >/dev/full");
    EXPECT_EQ(result.status, status_of(ErrorCode::kOutput)) << arguments;
    EXPECT_THAT(result.output, HasSubstr("standard output: cannot write")) << arguments;
  }
  EXPECT_EQ(run_edvo("config --set no.such=1 2>/dev/full").status, status_of(ErrorCode::kConfig));
}

TEST_F(HostileInput, ALimitOnFileSizesLeavesWholeLines) {
  test::write_sliding_sequence(folder_.path() / "sliding", {.frames = 100});
  const ProgramResult result =
      run_after("ulimit -f 60", "run " + place("sliding") + " -o " + place("out") + " 2>&1");
  EXPECT_EQ(result.status, status_of(ErrorCode::kOutput)) << result.output;
  EXPECT_THAT(result.output, HasSubstr("File too large"));
  std::istringstream lines(text_of(folder_.path() / "out/frames.jsonl"));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count)
    EXPECT_TRUE(nlohmann::json::accept(line)) << line;
  EXPECT_GT(count, 0);
}

TEST_F(HostileInput, ASignalBeforeTheFirstFrameEndsWithTheDocumentedStatus) {
  const std::string pipe = place("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const char* const signal : {"INT", "TERM", "HUP"}) {
    const ProgramResult result =
        run_edvo(std::string("--version >/dev/null; ") + EDVO_PROGRAM + " config --config " + pipe +
                 " & sleep 1; kill -" + signal + " $!; wait $!");
    EXPECT_EQ(result.status, 130) << signal;
  }
}

TEST_F(HostileInput, ImagesWithoutRoomForAGradientAreNoBugOfOurs) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 40), cv::Size(40, 1), cv::Size(7, 300)}) {
    const std::string name = fmt::format("{}x{}", size.width, size.height);
    for (int i = 0; i < 2; ++i) {
      test::write_colour(folder_.path() / name / "rgb" / fmt::format("{}.png", i), 100, size);
      test::write_depth(folder_.path() / name / "depth" / fmt::format("{}.png", i), 5000, size);
    }
    const ProgramResult result = run_edvo("run " + place(name) + " -o " + place("out") + " 2>&1");
    EXPECT_EQ(result.status, status_of(ErrorCode::kInput)) << name << result.output;
    EXPECT_THAT(result.output, HasSubstr("too small")) << name;
  }
}

TEST_F(HostileInput, NamesReachNeitherTheTerminalNorTheReportAsTheyAre) {
  const std::string name = "room\x1b[31m\x07\xE9";
  test::write_sliding_sequence(folder_.path() / name);
  const ProgramResult result = run_edvo("run \"" + place(name) + "\" -o " + place("out") + " 2>&1");
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, AllOf(HasSubstr("room?[31m"), Not(HasSubstr("\x1b")),
                                   Not(HasSubstr("\x07")), Not(HasSubstr("\xE9"))));
  EXPECT_THAT(text_of(folder_.path() / "out/report.html"),
              AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("room?[31m??\xE9"))));
  EXPECT_TRUE(nlohmann::json::accept(text_of(folder_.path() / "out/summary.json")));
}

TEST(Program, SaysItsVersionAndHelpsByWord) {
  EXPECT_THAT(run_edvo("--version").output, HasSubstr("edvo 0."));
  EXPECT_EQ(run_edvo("help").output, run_edvo("--help").output);
  EXPECT_EQ(run_edvo("help run").output, run_edvo("run --help").output);
  EXPECT_EQ(run_edvo("help run").status, 0);
  EXPECT_EQ(run_edvo("help frob 2>&1").status, status_of(ErrorCode::kUsage));
}

TEST(Program, SaysRangesInAFewDigits) {
  for (const char* const arguments :
       {"run x --max-frames abc", "run x --start -1", "run x --max-frames 0",
        "synth x --threads -1", "bench x --max-frames abc"}) {
    const ProgramResult result = run_edvo(std::string(arguments) + " 2>&1");
    EXPECT_EQ(result.status, status_of(ErrorCode::kUsage)) << arguments;
    EXPECT_LT(result.output.size(), 200U) << result.output;
  }
}

TEST(Program, TakesTheMethodInAnyCase) {
  EXPECT_EQ(run_edvo("config --method CANNY+CORNER").output,
            run_edvo("config --method canny+corner").output);
}

TEST_F(HostileInput, TheCacheIsListedAndCleared) {
  folder_.write("edvo/a.tgz-1f-2e/image", std::string(2'000'000, 'x'));
  folder_.write("edvo/models/model", "kept");
  const std::string cache = "export XDG_CACHE_HOME=" + folder_.path().string();
  const ProgramResult listed = run_after(cache, "cache");
  EXPECT_THAT(listed.output, AllOf(HasSubstr(place("edvo") + "\n"),
                                   HasSubstr("2.0 MB  a.tgz-1f-2e"), Not(HasSubstr("models/"))));
  EXPECT_THAT(run_after(cache, "cache clear").output, HasSubstr("2.0 MB removed"));
  EXPECT_FALSE(fs::exists(folder_.path() / "edvo/a.tgz-1f-2e"));
  EXPECT_TRUE(fs::exists(folder_.path() / "edvo/models/model"));
  EXPECT_EQ(run_after("unset HOME XDG_CACHE_HOME", "cache 2>&1").status,
            status_of(ErrorCode::kOutput));
}

}  // namespace
}  // namespace edvo
