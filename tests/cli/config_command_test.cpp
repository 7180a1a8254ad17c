// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/odometry/config.hpp"
#include "support/program.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

namespace edvo {
namespace {

using test::run_edvo;
using ::testing::HasSubstr;

TEST(ConfigCommand, DefaultTomlIsWhatTheProgramPrints) {
  std::ifstream file(EDVO_SOURCE_DIR "/configs/default.toml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(text, to_toml(preset(kDefaultMethod)))
      << "options changed: regenerate it with build/bin/edvo config > configs/default.toml";
  EXPECT_EQ(run_edvo("config").output, text);
}

TEST(ConfigCommand, EveryMethodHasALegalPreset) {
  for (const auto& [method, name] : EnumNames<Method>::names)
    EXPECT_EQ(run_edvo("config --method " + std::string(name)).output, to_toml(preset(method)));
}

TEST(ConfigCommand, AppliesTheFileAndThenEachSetting) {
  const auto result = run_edvo(
      "config --config /dev/stdin --set window.keyframes=3 <<'END'\n"
      "[window]\nkeyframes = 2\nEND");
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, HasSubstr("\nkeyframes = 3\n"));
}

TEST(ConfigCommand, RefusesWithTheExitStatusOfTheError) {
  const auto key = run_edvo("config --set window.keyframse=3 2>&1");
  EXPECT_EQ(key.status, static_cast<int>(ErrorCode::kConfig));
  EXPECT_THAT(key.output, HasSubstr("did you mean 'window.keyframes'?"));

  const auto method = run_edvo("config --method cany+corner 2>&1");
  EXPECT_EQ(method.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(method.output, HasSubstr("did you mean 'canny+corner'?"));

  for (const char* file : {"no/such/file.toml", "/"}) {
    const auto result = run_edvo(std::string("config 2>&1 --config ") + file);
    EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kConfig));
    EXPECT_THAT(result.output, HasSubstr(std::string(file) + ": cannot read"));
  }
}

TEST(CommandLine, NamesTheNearestVerbAndOption) {
  const auto verb = run_edvo("confg 2>&1");
  EXPECT_EQ(verb.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(verb.output, HasSubstr("unknown verb 'confg', did you mean 'config'?"));

  const auto option = run_edvo("config --methd canny 2>&1");
  EXPECT_EQ(option.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(option.output, HasSubstr("unknown option '--methd', did you mean '--method'?"));
}

TEST(CommandLine, AnOptionThatIsGivenTwiceIsNamedWithItsValues) {
  const auto twice = run_edvo("config --method canny --method cnn 2>&1");
  EXPECT_EQ(twice.status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_THAT(twice.output, HasSubstr("--method is given 2 times (canny, cnn)"));
}

TEST(CommandLine, HelpSucceedsAndNoVerbDoesNot) {
  EXPECT_EQ(run_edvo("--help").status, 0);
  EXPECT_EQ(run_edvo("config --help").status, 0);
  EXPECT_EQ(run_edvo("2>&1").status, static_cast<int>(ErrorCode::kUsage));
}

TEST(ConfigCommand, SaysOfAValueThatItIsNoNumber) {
  const auto result = run_edvo("config --set selection.max_depth=abc 2>&1");
  EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kConfig));
  EXPECT_THAT(result.output,
              HasSubstr("--set selection.max_depth=abc: the value is neither a number"));
}

}  // namespace
}  // namespace edvo
