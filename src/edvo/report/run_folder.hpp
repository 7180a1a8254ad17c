// SPDX-License-Identifier: MIT
// Where a run puts its results, without ever silently replacing earlier ones.
#pragma once

#include <filesystem>
#include <string>

namespace edvo {

// The files of a run; replacing a run with `force` removes these and nothing else.
inline constexpr const char* kRunFiles[] = {
    "frames.jsonl", "trajectory.tum",     "trajectory_online.tum", "keyframes.tum",
    "links.jsonl",  "localization.jsonl", "map_links.jsonl",       "summary.json",
    "config.toml",  "report.html",        "groundtruth.tum",
};

// The name as that of a folder: letters, digits and . _ - + stay, everything else becomes '_'.
[[nodiscard]] std::string folder_name(const std::string& name);

// Creates <runs>/<sequence>/<UTC stamp>/, new whatever is there already, and lets the link
// <runs>/<sequence>/latest point to it. Throws Error(kOutput).
[[nodiscard]] std::filesystem::path make_stamped_run_folder(const std::filesystem::path& runs,
                                                            const std::string& sequence);

// Creates the folder, or takes it if it is empty. One with anything in it is refused with
// Error(kOutput) unless force is set; then the files of an earlier run in it are removed.
void make_named_run_folder(const std::filesystem::path& folder, bool force);

}  // namespace edvo
