// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "support/program.hpp"
#include "support/temporary_folder.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_edvo;
using ::testing::HasSubstr;

// Small and short: about a second.
constexpr const char* kSmallDemo = "demo --size 160x120 --frames 40 ";

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(DemoCommand, TracksWhatItRendersAndWritesAReport) {
  const test::TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const auto result = run_edvo(kSmallDemo + ("--json -o " + out.string()) + " 2>/dev/null");
  ASSERT_EQ(result.status, 0);
  const json summary = json::parse(result.output);
  EXPECT_EQ(summary["frames"]["tracked"], 40);
  EXPECT_EQ(summary["seed"], 0);
  EXPECT_LT(summary["evaluation"]["final"]["ate_rmse_m"], 0.02);
  EXPECT_THAT(text_of(out / "report.html"), HasSubstr("rendered: scene office"));
}

TEST(DemoCommand, GivesTheSameBitsTwiceAndWithAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  std::vector<std::string> trajectories;
  for (const char* threads : {"1", "2", "3", "3"}) {
    const fs::path out = folder.path() / fmt::format("out{}", trajectories.size());
    const auto result = run_edvo(kSmallDemo + ("--no-report -o " + out.string()) + " --threads " +
                                 threads + " 2>&1");
    ASSERT_EQ(result.status, 0) << result.output;
    trajectories.push_back(text_of(out / "trajectory.tum"));
    EXPECT_EQ(trajectories.back(), trajectories.front());
  }
}

TEST(DemoCommand, RefusesWhatItCannotRender) {
  EXPECT_EQ(run_edvo("demo --frames 0 2>/dev/null").status, static_cast<int>(ErrorCode::kUsage));
  EXPECT_EQ(run_edvo("demo --scene moon 2>/dev/null").status, static_cast<int>(ErrorCode::kUsage));
}

}  // namespace
}  // namespace edvo
