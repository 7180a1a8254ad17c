// SPDX-License-Identifier: MIT
// A page that lays several finished runs side by side.
#pragma once

#include "edvo/report/stored_run.hpp"

#include <string>
#include <vector>

namespace edvo {

// Runs by short names: the last part of their folders where that tells them apart, else the folders
// as given.
[[nodiscard]] std::vector<std::string> short_names(const std::vector<StoredRun>& runs);

// Self-contained, as the report of one run is: a table of the numbers, then trajectories, errors,
// quality and times of all runs in the same plots. Where two runs have the same ground truth, they
// are drawn in the frame of the first one; else each in that of its own first camera.
[[nodiscard]] std::string comparison_page(const std::vector<StoredRun>& runs);

}  // namespace edvo
