// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "support/program.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <iterator>
#include <nlohmann/json.hpp>

namespace edvo {
namespace {

namespace fs = std::filesystem;

using nlohmann::json;
using test::ProgramResult;
using test::run_edvo;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// A manifest beside a short rendered sequence, long enough for errors over one second.
struct BenchCommand : testing::Test {
  test::TemporaryFolder folder;
  fs::path manifest = folder.path() / "some.toml";
  fs::path runs = folder.path() / "runs";

  void render_sequence() const {
    const ProgramResult made =
        run_edvo("synth " + (folder.path() / "room").string() +
                 " --size 160x120 --frames 15 --rate 10 --path xyz --noise off 2>&1");
    ASSERT_EQ(made.status, 0) << made.output;
  }

  void write(std::string_view text) const { folder.write("some.toml", text); }

  [[nodiscard]] ProgramResult bench(const std::string& arguments) const {
    return run_edvo("bench " + manifest.string() + " --no-report --threads 1 -o " + runs.string() +
                    " " + arguments);
  }

  [[nodiscard]] json bench_json(const std::string& arguments = "") const {
    const ProgramResult result = bench("--json --quiet " + arguments);
    return json::parse(result.output, nullptr, false);
  }

  void expect_refusal(std::string_view text, ErrorCode code, const std::string& message,
                      const std::string& arguments = "") const {
    write(text);
    const ProgramResult result = bench(arguments + " 2>&1");
    EXPECT_EQ(result.status, static_cast<int>(code)) << result.output;
    EXPECT_THAT(result.output, HasSubstr(message));
    EXPECT_FALSE(fs::exists(runs)) << "something ran";
  }
};

const std::string kWhole = "published = \"" EDVO_SOURCE_DIR "/benchmarks/paper_tables.toml\"\n" +
                           std::string(R"(methods = ["canny+corner", "canny"]
repeats = 2
[[sequence]]
name = "fr1/xyz"
path = "room"
[[sequence.peer]]
name = "ORB-SLAM2"
trajectory = "room/groundtruth.txt"
[[sequence.peer]]
name = "A Peer"
trajectory = "room/groundtruth.txt"
[[variant]]
name = "no window"
set = ["window.keyframes=0"]
)");

std::string line_with(const std::string& text, const std::string& start) {
  const std::size_t begin = text.find("\n" + start);
  if (begin == std::string::npos) return "no line starts with " + start;
  return text.substr(begin + 1, text.find('\n', begin + 1) - begin - 1);
}

TEST_F(BenchCommand, PrintsThePapersTablesWithItsFiguresAndOurs) {
  render_sequence();
  write(kWhole);
  const ProgramResult result = bench("2>/dev/null");
  EXPECT_EQ(result.status, 0);
  const std::string rpe = result.output.substr(0, result.output.find("Table II"));
  const std::string ate = result.output.substr(rpe.size());
  EXPECT_THAT(line_with(rpe, "sequence"),
              AllOf(HasSubstr("ORB-SLAM2 R  ORB-SLAM2 T  Origin R  Origin T"),
                    HasSubstr("Canny+Corner T  CNN+Corner R  CNN+Corner T")));
  EXPECT_THAT(line_with(rpe, "fr1/xyz, paper"), AllOf(HasSubstr("0.978583     0.015260  1.568226"),
                                                      HasSubstr("0.724896      0.025371")));
  EXPECT_THAT(line_with(ate, "fr1/xyz, paper"), HasSubstr("0.009436  0.045409"));
  // The peer of the column's name is perfect here, origin and cnn+corner did not take part.
  EXPECT_THAT(line_with(ate, "fr1/xyz, measured"),
              testing::MatchesRegex("fr1/xyz, measured +0.000000 +- +0.0[0-9]+ +-"));
  for (const char* system : {"canny+corner ", "canny ", "canny+corner, no window ", "A Peer "})
    EXPECT_THAT(line_with(ate, system), Not(HasSubstr("no line"))) << system;
  EXPECT_THAT(result.output, AllOf(HasSubstr("15 frames"), HasSubstr("paper: Lu et al."),
                                   HasSubstr("measured: TUM protocol"),
                                   HasSubstr("2 runs each, with the same trajectories")));
}

TEST_F(BenchCommand, ComparesPeersOnTheFramesThatWereUsed) {
  render_sequence();
  write(kWhole);
  const auto pairs_of_peers = [&](const std::string& arguments) {
    const json result = bench_json("--repeats 1 " + arguments);
    std::vector<int> pairs;
    for (const json& system : result["sequences"][0]["systems"])
      if (system["kind"] == "peer") pairs.push_back(system["errors"]["pairs"]);
    return pairs;
  };
  const std::vector<int> all = pairs_of_peers(""), few = pairs_of_peers("--max-frames 6");
  ASSERT_EQ(all.size(), 2u);
  ASSERT_EQ(few.size(), 2u);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_GT(few[i], 0);
    EXPECT_LT(few[i], all[i] / 2);
  }
}

TEST_F(BenchCommand, RunsAnewWhereTheEarlierSummaryIsNestedWithoutEnd) {
  render_sequence();
  write(kWhole);
  fs::create_directories(runs / "fr1_xyz/canny/1");
  std::ofstream(runs / "fr1_xyz/canny/1/summary.json") << std::string(300'000, '[');
  std::ofstream(runs / "fr1_xyz/canny/1/frames.jsonl") << "";
  const json result = bench_json("--repeats 1 --max-frames 3");
  ASSERT_TRUE(result.is_object());
  EXPECT_EQ(result["sequences"][0]["systems"][1]["state"], "done");
}

TEST_F(BenchCommand, LeavesARunFolderPerRepeatAndDoesNotRunThemAgain) {
  render_sequence();
  write(kWhole);
  const json first = bench_json();
  ASSERT_TRUE(first.is_object());
  const fs::path run = runs / "fr1_xyz" / "no_window" / "2";
  EXPECT_TRUE(fs::exists(run / "summary.json"));
  const fs::file_time_type written = fs::last_write_time(run / "summary.json");

  const json second = bench_json();
  EXPECT_EQ(written, fs::last_write_time(run / "summary.json"));
  for (int i = 0; i < 3; ++i) {
    const json &before = first["sequences"][0]["systems"][i],
               &after = second["sequences"][0]["systems"][i];
    EXPECT_EQ(before["reused_runs"], 0);
    EXPECT_EQ(after["reused_runs"], 2);
    EXPECT_EQ(after["errors"], before["errors"]);
    EXPECT_EQ(after["run"], before["run"]);
    EXPECT_EQ(after["identical"], true);
  }
}

TEST_F(BenchCommand, RunsAgainWhatIsIncompleteChangedOrForced) {
  render_sequence();
  write("methods = [\"canny\"]\n[[sequence]]\nname = \"room\"\npath = \"room\"\n");
  const auto reused = [](const json& result) {
    return result["sequences"][0]["systems"][0]["reused_runs"].get<int>();
  };
  EXPECT_EQ(reused(bench_json()), 0);
  EXPECT_EQ(reused(bench_json()), 1);
  EXPECT_EQ(reused(bench_json("--force")), 0);
  // Other data under the same names.
  const fs::path image = fs::directory_iterator(folder.path() / "room" / "depth")->path();
  fs::last_write_time(image, fs::last_write_time(image) + std::chrono::seconds(2));
  EXPECT_EQ(reused(bench_json()), 0);
  EXPECT_EQ(reused(bench_json()), 1);
  fs::remove(runs / "room" / "canny" / "1" / "summary.json");
  EXPECT_EQ(reused(bench_json()), 0);
  // Other options under the same name.
  write(R"([[variant]]
name = "canny"
method = "canny"
set = ["window.keyframes=0"]
[[sequence]]
name = "room"
path = "room"
)");
  EXPECT_EQ(reused(bench_json()), 0);
  EXPECT_EQ(reused(bench_json()), 1);
}

TEST_F(BenchCommand, GoesOnAfterASequenceThatFails) {
  render_sequence();
  fs::create_directories(folder.path() / "empty");
  write(R"(methods = ["canny"]
[[sequence]]
name = "nothing"
path = "empty"
[[sequence]]
name = "room"
path = "room"
)");
  const ProgramResult result = bench("2>/dev/null");
  EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kTrackingLost));
  EXPECT_THAT(result.output, HasSubstr("All systems on nothing, could not be opened"));
  EXPECT_THAT(result.output, HasSubstr("\ncanny    failed "));
  EXPECT_THAT(result.output, HasSubstr("\ncanny   0.0"));
  EXPECT_THAT(result.output, HasSubstr("\nnothing: " + (folder.path() / "empty").string()));
}

TEST_F(BenchCommand, SaysThatTrackingWasLost) {
  render_sequence();
  write(R"([[variant]]
name = "impossible"
set = ["selection.min_gradient=255"]
[[sequence]]
name = "room"
path = "room"
)");
  for (const char* again : {"", "from the run that is there"}) {
    const ProgramResult result = bench("2>/dev/null");
    EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kTrackingLost)) << again;
    EXPECT_THAT(result.output, HasSubstr("\ncanny+corner, impossible     lost "));
    EXPECT_THAT(result.output, HasSubstr("tracking lost: 15 lost and 0 skipped of 15 frames"));
  }
}

TEST_F(BenchCommand, SpeaksOtherFormats) {
  render_sequence();
  write(kWhole);
  const auto output = [this](const std::string& format) {
    return bench("--repeats 1 --quiet --format " + format).output;
  };
  EXPECT_THAT(output("markdown"), HasSubstr("\n| fr1/xyz, paper "));
  EXPECT_THAT(output("csv"), AllOf(HasSubstr("\nsequence,system,ATE [m],live ATE [m],"),
                                   HasSubstr("\nfr1/xyz,\"canny+corner, no window\",0.0")));
  EXPECT_THAT(output("latex"), HasSubstr("\nfr1/xyz, paper & 0.978583 & "));
}

TEST_F(BenchCommand, FindsDataAndLeavesPeersOutWhereToldTo) {
  render_sequence();
  fs::create_directories(folder.path() / "data");
  fs::rename(folder.path() / "room", folder.path() / "data" / "room");
  fs::remove(folder.path() / "data" / "room" / "groundtruth.txt");
  write(kWhole);
  const std::string data = "--repeats 1 --data " + (folder.path() / "data").string();
  const json result = bench_json("--no-peers " + data);
  ASSERT_TRUE(result.is_object());
  const json& systems = result["sequences"][0]["systems"];
  ASSERT_EQ(systems.size(), 3u);
  EXPECT_EQ(systems[0]["state"], "done");
  EXPECT_EQ(systems[0]["problem"], "no ground truth");
  EXPECT_EQ(systems[0]["errors"], nullptr);
}

TEST_F(BenchCommand, RefusesAManifestByLineBeforeAnythingRuns) {
  fs::create_directories(folder.path() / "room");
  const std::string sequence = "[[sequence]]\nname = \"a\"\npath = \"room\"\n";
  const std::string all = "methods = [\"canny\"]\n" + sequence;
  const auto refuses = [this](const std::string& text, const std::string& message) {
    expect_refusal(text, ErrorCode::kConfig, manifest.string() + ":" + message);
  };
  refuses("methods = [\n", "1: not valid TOML");
  refuses("\nmetods = []\n", "2: unknown key 'metods', did you mean 'methods'?");
  refuses("methods = \"canny\"", "1: methods: expected a list");
  refuses("methods = [\"cany\"]", "1: unknown method 'cany', did you mean 'canny'?");
  refuses("methods = [\"canny\", \"canny\"]", "1: 'canny' is there twice");
  refuses(sequence, "1: nothing to run");
  refuses("methods = [\"canny\"]", "1: no sequence");
  refuses("repeats = 0\n" + all, "1: repeats: expected a whole number from 1");
  refuses(all + "pth = \"x\"", "5: unknown key 'pth', did you mean 'path'?");
  refuses(all + sequence, "5: 'a' is there twice");
  refuses(all + "depth_scale = 0", "5: depth_scale: expected a number above 0");
  refuses(all + "ground_truth = \"gone.txt\"",
          "5: ground_truth: " + (folder.path() / "gone.txt").string() + " is not there");
  refuses(all + "[[sequence.peer]]\nname = \"p\"\ntrajectory = \"gone.txt\"",
          "7: trajectory: " + (folder.path() / "gone.txt").string() + " is not there");
  refuses(all + "[[sequence.peer]]\nname = \"canny\"\ntrajectory = \"room\"",
          "5: 'canny' is there twice");
  refuses(all + "[[variant]]\nname = \"v\"", "5: variant 'v': 'set' is missing");
  refuses(all + "[[variant]]\nname = \"v\"\nset = [\"window.keyframe=0\"]",
          "7: unknown key 'window.keyframe', did you mean 'window.keyframes'?");
  refuses("methods = [\"canny\"]\n[[sequence]]\nname = \"a\"\n", "2: 'path' is missing");
}

TEST_F(BenchCommand, RefusesTrajectoriesAndOptionsThatItCannotRead) {
  folder.write("room/peer.txt", "1 2 3\n");
  expect_refusal(R"(methods = ["canny"]
[[sequence]]
name = "a"
path = "room"
ground_truth = "room/peer.txt"
)",
                 ErrorCode::kInput, "room/peer.txt:1: expected 8 fields");
  expect_refusal(kWhole, ErrorCode::kUsage, "/no/such/folder", "--data /no/such/folder");
  expect_refusal(kWhole, ErrorCode::kUsage, "xml", "--format xml");
  fs::remove(manifest);
  EXPECT_EQ(bench("2>/dev/null").status, static_cast<int>(ErrorCode::kInput));
}

TEST(Benchmarks, ShippedManifestsNameOptionsThatThereAre) {
  // Its first complaint is about data, which come after the variants.
  const ProgramResult result = run_edvo("bench " EDVO_SOURCE_DIR "/benchmarks/fr1.toml 2>&1");
  EXPECT_THAT(result.output, HasSubstr("rgbd_dataset_freiburg1_xyz is not there"));
}

}  // namespace
}  // namespace edvo
