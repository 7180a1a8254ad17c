// SPDX-License-Identifier: MIT
// A finished run, read back from its folder.
#pragma once

#include "edvo/report/summary.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace edvo {

struct StoredRun {
  std::filesystem::path folder;
  RunSummary summary;
  RunLog log;
  RunOutcome outcome;                     // its counts, trajectories and evaluation
  std::vector<std::string> missing = {};  // what the folder does not tell, one sentence each
};

// Numbers are those of summary.json. Curves of errors come from the ground truth that the run has
// left in groundtruth.tum, pictures of the worst frames from its report.html; a run without them
// has none. Throws Error(kInput) that says what is wrong and what mends it, if the folder is not
// that of a run, or the run has not ended, or a file is missing or damaged.
[[nodiscard]] StoredRun read_run(const std::filesystem::path& folder);

}  // namespace edvo
