// SPDX-License-Identifier: MIT
#include "edvo/io/file.hpp"
#include "support/program.hpp"
#include "support/sliding_sequence.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using test::run_edvo;
using ::testing::HasSubstr;

class ReportCommand : public testing::Test {
 protected:
  void SetUp() override {
    test::write_sliding_sequence(folder_.path() / "sliding");
    for (const char* name : {"one", "two"})
      ASSERT_EQ(run_edvo("run " + path("sliding") + " -o " + path(name) + " --quiet 2>&1").status,
                0);
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }

  test::TemporaryFolder folder_;
};

TEST_F(ReportCommand, ComparesRunsOnOnePage) {
  const auto result =
      run_edvo("report " + path("one") + " " + path("two") + " -o " + path("page.html") + " 2>&1");
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr(path("page.html")));
  const std::string page = read_file(path("page.html"));
  for (const char* part : {"Comparison of 2 runs", "ATE [cm]", "Absolute error over time"})
    EXPECT_THAT(page, HasSubstr(part));
}

TEST_F(ReportCommand, MakesTheReportOfOneRunAnew) {
  const std::string report = path("one/report.html");
  ASSERT_THAT(read_file(report), HasSubstr("data:image/jpeg"));
  // Not removed: the pictures are in it and nowhere else.
  std::ofstream(report, std::ios::app) << "changed";
  ASSERT_EQ(run_edvo("report " + path("one") + " 2>&1").status, 0);
  const std::string page = read_file(report);
  EXPECT_EQ(page.find("changed"), page.npos);
  EXPECT_THAT(page, HasSubstr("data:image/jpeg"));
  EXPECT_THAT(page, HasSubstr("Absolute error over time"));
}

TEST_F(ReportCommand, RefusesWhatIsNoRun) {
  const auto result = run_edvo("report " + path("sliding") + " 2>&1");
  EXPECT_EQ(result.status, 3);
  EXPECT_THAT(result.output, HasSubstr("sliding: is not the folder of a run"));
}

TEST_F(ReportCommand, IsInTheHelpTheManualAndTheCompletion) {
  EXPECT_THAT(run_edvo("--help").output, HasSubstr("Compare finished runs on one page"));
  EXPECT_THAT(run_edvo("manual").output, HasSubstr("edvo report"));
  EXPECT_THAT(run_edvo("completion").output, HasSubstr("report"));
}

TEST_F(ReportCommand, ReplacesNothingButPages) {
  const std::string runs = "report " + path("one") + " " + path("two") + " -o ";
  const std::string poses = path("one") + "/trajectory.tum";
  const std::string before = read_file(poses);
  EXPECT_EQ(run_edvo(runs + poses + " --force 2>&1").status, 2);
  EXPECT_EQ(read_file(poses), before);
  ASSERT_EQ(run_edvo(runs + path("twice.html") + " 2>&1").status, 0);
  const auto again = run_edvo(runs + path("twice.html") + " 2>&1");
  EXPECT_EQ(again.status, 7);
  EXPECT_THAT(again.output, HasSubstr("--force"));
  EXPECT_EQ(run_edvo(runs + path("twice.html") + " --force 2>&1").status, 0);
}

}  // namespace
}  // namespace edvo
