// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"
#include "support/shared_data.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace edvo {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::run_edvo;
using ::testing::HasSubstr;
using ::testing::Not;

// A ground truth and two estimates: the same, and one a little too large.
struct EvalCommand : testing::Test {
  test::TemporaryFolder folder;
  std::string truth = (folder.path() / "gt.txt").string();
  std::string same = (folder.path() / "same.txt").string();
  std::string large = (folder.path() / "large.txt").string();

  EvalCommand() {
    const Trajectory path = test::winding_path(60);
    write_trajectory(truth, path);
    write_trajectory(same, path);
    write_trajectory(large, test::stretched(1.01, path));
  }

  // Expects the exit status of the code and a message holding each part.
  static void expect_failure(const std::string& arguments, ErrorCode code,
                             const std::vector<std::string>& parts) {
    const ProgramResult result = run_edvo("eval " + arguments + " 2>&1 >/dev/null");
    EXPECT_EQ(result.status, static_cast<int>(code)) << result.output;
    for (const std::string& part : parts) EXPECT_THAT(result.output, HasSubstr(part));
  }
};

TEST_F(EvalCommand, PrintsARowPerEstimateUnderItsProtocol) {
  const ProgramResult result = run_edvo("eval " + truth + " " + same + " " + large + " 2>&1");
  EXPECT_EQ(result.status, 0);
  for (const char* part :
       {"TUM protocol", "SE(3)-aligned", "fixed delta 1s", "ATE rmse [m]", "RPE trans [m/s]",
        "RPE rot [deg/s]", "drift [%]", "\nsame ", "\nlarge ", "0.000000", "100.0",
        "with evo: evo_ape tum", " EST -a --t_max_diff 0.02 && evo_rpe tum"})
    EXPECT_THAT(result.output, HasSubstr(part));
}

TEST_F(EvalCommand, PrintsOneJsonObject) {
  for (const char* option : {"--json", "--format json"}) {
    const ProgramResult result = run_edvo("eval " + truth + " " + large + " " + option);
    EXPECT_EQ(result.status, 0);
    const json object = json::parse(result.output);
    EXPECT_EQ(object["protocol"]["delta"], "1s");
    EXPECT_EQ(object["ground_truth"]["poses"], 60);
    const json& estimate = object["estimates"][0];
    EXPECT_EQ(estimate["name"], "large");
    EXPECT_EQ(estimate["pairs"], 60);
    EXPECT_GT(estimate["ate"]["distance"]["rmse"], 1e-3);
    EXPECT_EQ(estimate["rpe"]["translation_unit"], "m/s");
    EXPECT_EQ(estimate["evo"].size(), 3u);
  }
}

TEST_F(EvalCommand, SpeaksOtherFormats) {
  const std::string command = "eval " + truth + " " + same + " --format ";
  EXPECT_THAT(run_edvo(command + "markdown").output, HasSubstr("\n| name |"));
  EXPECT_THAT(run_edvo(command + "csv").output, HasSubstr("\nname,pairs,"));
  EXPECT_THAT(run_edvo(command + "latex").output, HasSubstr("\\begin{tabular}"));
}

TEST_F(EvalCommand, PrintsTheCommandOfEvoAsItIsTyped) {
  const std::string command = "eval " + truth + " " + same + " --format markdown";
  EXPECT_THAT(run_edvo(command).output, HasSubstr("with evo: `evo_ape tum "));
  EXPECT_THAT(run_edvo(command).output, HasSubstr(" && evo_rpe"));
}

TEST_F(EvalCommand, TakesTheFolderOfARun) {
  const std::filesystem::path run = folder.path() / "a.run";
  std::filesystem::create_directories(run);
  std::filesystem::copy_file(same, run / "trajectory.tum");
  const ProgramResult result = run_edvo("eval " + truth + " " + run.string() + "/ --json");
  ASSERT_EQ(result.status, 0) << result.output;
  const json estimate = json::parse(result.output)["estimates"][0];
  EXPECT_EQ(estimate["name"], "a.run");
  EXPECT_EQ(estimate["file"], (run / "trajectory.tum").string());
}

TEST_F(EvalCommand, HeedsItsOptions) {
  const std::string command = "eval " + truth + " " + large + " ";
  EXPECT_THAT(run_edvo(command + "--delta 10f").output, HasSubstr("[m per 10 frames]"));
  EXPECT_THAT(run_edvo(command + "--align none").output, HasSubstr("not aligned"));
  EXPECT_THAT(run_edvo(command + "--align sim3").output,
              testing::AllOf(HasSubstr("0.990099"), HasSubstr(" -as ")));
  EXPECT_THAT(run_edvo(command + "--protocol evo").output, HasSubstr("fixed delta 1f"));
  EXPECT_THAT(run_edvo(command + "--frames 120").output, HasSubstr(" 50.0 "));
  EXPECT_THAT(run_edvo(command + "--offset=-0.1").output, HasSubstr("--t_offset -0.1"));
  EXPECT_THAT(run_edvo(command + "--max-diff 0.005").output, HasSubstr("< 0.005 s"));
}

TEST_F(EvalCommand, WritesPlots) {
  const std::filesystem::path plots = folder.path() / "new" / "plots";
  EXPECT_EQ(run_edvo("eval " + truth + " " + large + " --plot " + plots.string() + " 2>&1").status,
            0);
  for (const char* name :
       {"trajectory.svg", "ate.svg", "rpe_translation.svg", "rpe_rotation.svg"}) {
    std::ifstream file(plots / name);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_THAT(text, testing::StartsWith("<svg ")) << name;
    EXPECT_THAT(text, testing::EndsWith("</svg>\n")) << name;
    EXPECT_THAT(text, Not(HasSubstr("nan"))) << name;
  }
}

TEST_F(EvalCommand, ReplacesNoPlotsUnasked) {
  const std::string command = "eval " + truth + " " + large + " --plot " + folder.path().string();
  ASSERT_EQ(run_edvo(command + " 2>&1").status, 0);
  const ProgramResult again = run_edvo(command + " 2>&1");
  EXPECT_EQ(again.status, static_cast<int>(ErrorCode::kOutput));
  EXPECT_THAT(again.output, HasSubstr("--force"));
  EXPECT_EQ(run_edvo(command + " --force 2>&1").status, 0);
}

TEST_F(EvalCommand, ShowsTheOthersWhereOneEstimateDoesNotOverlap) {
  const std::string late = folder.write("late.txt", "500 0 0 0 0 0 0 1\n").string();
  const ProgramResult result = run_edvo("eval " + truth + " " + late + " " + same + " 2>&1");
  EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kEvaluation));
  EXPECT_THAT(result.output, HasSubstr("\nsame "));
  EXPECT_THAT(result.output, HasSubstr("500 .. 500"));
}

TEST_F(EvalCommand, SaysWhichScaleFits) {
  Trajectory half = read_trajectory(truth).trajectory;
  for (StampedPose& pose : half) pose.world_from_camera.translation *= 0.5;
  write_trajectory(folder.path() / "half.txt", half);
  const std::string command = "eval " + truth + " " + (folder.path() / "half.txt").string();
  EXPECT_THAT(run_edvo(command + " 2>&1").output, HasSubstr("scaled by 2 it fits"));
  EXPECT_THAT(run_edvo(command + " --frames 1 2>&1").output,
              testing::AllOf(HasSubstr("60 poses of 1 frames"), HasSubstr(" 100.0 ")));
}

TEST_F(EvalCommand, NamesMilliseconds) {
  std::string text;
  for (int i = 0; i < 60; ++i) text += std::to_string(100000 + 100 * i) + " 0 0 0 0 0 0 1\n";
  expect_failure(truth + " " + folder.write("ms.txt", text).string(), ErrorCode::kEvaluation,
                 {"milliseconds, divide them by 1000"});
}

TEST_F(EvalCommand, TakesTheGroundTruthAsItsOwnEstimate) {
  const json object = json::parse(run_edvo("eval " + truth + " " + truth + " --json").output);
  EXPECT_LT(object["estimates"][0]["ate"]["distance"]["rmse"], 1e-9);
}

TEST_F(EvalCommand, TellsEstimatesOfTheSameNameApart) {
  const std::string twin = folder.write("other/same.txt", "").string();
  std::filesystem::copy_file(same, twin, std::filesystem::copy_options::overwrite_existing);
  const ProgramResult result = run_edvo("eval " + truth + " " + same + " " + twin);
  EXPECT_THAT(result.output, HasSubstr("\n" + same + " "));
  EXPECT_THAT(result.output, HasSubstr("\n" + twin + " "));
}

TEST_F(EvalCommand, QuotesFileNamesForTheShell) {
  const std::filesystem::path odd = folder.path() / "it's a file.txt";
  std::filesystem::copy_file(same, odd);
  const ProgramResult result = run_edvo("eval " + truth + " \"" + odd.string() + "\"");
  EXPECT_THAT(result.output,
              HasSubstr("'" + (folder.path() / "it'\\''s a file.txt").string() + "'"));
}

TEST_F(EvalCommand, RefusesBadFiles) {
  const std::string empty = folder.write("empty.txt", "# nothing\n").string();
  const std::string nan = folder.write("nan.txt", "0 0 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n").string();
  const std::string columns = folder.write("columns.txt", "0 1 2 3\n").string();
  const std::string late = folder.write("late.txt", "500 0 0 0 0 0 0 1\n").string();
  const std::string one = folder.write("one.txt", "1.0 0 0 0 0 0 0 1\n").string();
  expect_failure(truth + " /no/such.txt", ErrorCode::kInput, {"/no/such.txt"});
  expect_failure("/no/such.txt " + same, ErrorCode::kInput, {"/no/such.txt"});
  expect_failure(truth + " " + folder.path().string(), ErrorCode::kInput, {"not a regular file"});
  expect_failure(truth + " " + empty, ErrorCode::kInput, {empty, "no pose"});
  expect_failure(truth + " " + nan, ErrorCode::kInput, {nan + ":2:", "nan"});
  expect_failure(truth + " " + columns, ErrorCode::kInput, {columns + ":1:", "expected 8"});
  expect_failure(truth + " " + late, ErrorCode::kEvaluation,
                 {late, "500 .. 500", "0.000 .. 5.900"});
  expect_failure(truth + " " + one, ErrorCode::kEvaluation, {one, "1 of 1 poses", "at least 3"});
}

TEST_F(EvalCommand, RefusesBadOptions) {
  const std::string files = truth + " " + same;
  expect_failure(truth, ErrorCode::kUsage, {"EST"});
  expect_failure(files + " --delta 5", ErrorCode::kUsage, {"\"5\"", "30f"});
  expect_failure(files + " --align se2", ErrorCode::kUsage, {"se2"});
  expect_failure(files + " --max-diff 0", ErrorCode::kUsage, {"max-diff"});
  expect_failure(files + " --format xml", ErrorCode::kUsage, {"xml"});
  expect_failure(files + " --protocol evo --delta 1s", ErrorCode::kUsage, {"1s"});
}

TEST_F(EvalCommand, SaysWhereItCannotWritePlots) {
  expect_failure(truth + " " + same + " --plot /proc/plots", ErrorCode::kOutput, {"/proc/plots"});
}

TEST_F(EvalCommand, WarnsOnTheSide) {
  const std::string messy =
      folder.write("messy.txt", "2 2 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n0 0 1 0 0 0 0 1\n").string();
  const std::string command = "eval " + truth + " " + messy;
  EXPECT_THAT(run_edvo(command + " 2>&1 >/dev/null").output, HasSubstr("poses were sorted"));
  EXPECT_THAT(run_edvo(command + " 2>/dev/null").output, Not(HasSubstr("warning")));
}

TEST_F(EvalCommand, GivesTheGoldenNumbers) {
  const std::filesystem::path data = test::shared_data() / "evaluation";
  EDVO_REQUIRE_SHARED(data);
  const std::string command = "eval " + (data / "fr2_desk_groundtruth.txt").string() + " " +
                              (data / "fr2_desk_ORB.txt").string() + " 2>/dev/null";
  const std::string output = run_edvo(command).output;
  for (const char* number : {" 2223 ", " 0.008144 ", " 0.007161 ", " 0.455005 "})
    EXPECT_THAT(output, HasSubstr(number));
}

}  // namespace
}  // namespace edvo
