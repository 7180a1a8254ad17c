// SPDX-License-Identifier: MIT
#include "edvo/report/run_folder.hpp"

#include "edvo/core/error.hpp"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <cctype>
#include <ctime>
#include <system_error>

namespace edvo {
namespace {

namespace fs = std::filesystem;

void create_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(ErrorCode::kOutput,
                fmt::format("{}: cannot create the folder: {}; choose another with -o",
                            folder.string(), error.message()));
}

// A convenience: a folder that cannot hold links (or something of the user's named "latest") is no
// reason to stop a run.
void point_latest_at(const fs::path& folder) {
  const fs::path link = folder.parent_path() / "latest";
  const fs::path fresh = folder.parent_path() / (".latest-" + folder.filename().string());
  std::error_code error;
  if (fs::exists(fs::symlink_status(link)) && !fs::is_symlink(fs::symlink_status(link))) return;
  fs::create_directory_symlink(folder.filename(), fresh, error);
  if (error) return;
  fs::rename(fresh, link, error);
  if (error) fs::remove(fresh, error);
}

}  // namespace

std::string folder_name(const std::string& name) {
  std::string folder;
  for (const char c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '_' ||
                       c == '-' || c == '+';
    folder += plain ? c : '_';
  }
  if (folder.empty() || folder.find_first_not_of('.') == std::string::npos) folder = "sequence";
  return folder;
}

fs::path make_stamped_run_folder(const fs::path& runs, const std::string& sequence) {
  const fs::path parent = runs / folder_name(sequence);
  create_folders(parent);
  const std::string stamp = fmt::format("{:%Y%m%dT%H%M%SZ}", fmt::gmtime(std::time(nullptr)));
  for (int attempt = 1;; ++attempt) {
    const fs::path folder = parent / (attempt == 1 ? stamp : fmt::format("{}-{}", stamp, attempt));
    std::error_code error;
    if (fs::create_directory(folder, error)) {
      point_latest_at(folder);
      return folder;
    }
    if (error)
      throw Error(ErrorCode::kOutput,
                  fmt::format("{}: cannot create the folder: {}; choose another with -o",
                              folder.string(), error.message()));
  }
}

void make_named_run_folder(const fs::path& folder, bool force) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    throw Error(
        ErrorCode::kOutput,
        fmt::format("{}: is a file, not a folder; choose another with -o", folder.string()));
  create_folders(folder);
  const bool empty = fs::is_empty(folder, error);
  if (error)
    throw Error(ErrorCode::kOutput,
                fmt::format("{}: cannot read the folder: {}; choose another with -o",
                            folder.string(), error.message()));
  if (empty) return;
  if (!force) {
    const bool a_run = fs::exists(folder / "frames.jsonl", error);
    throw Error(ErrorCode::kOutput,
                fmt::format("{}: {}; choose another folder, or replace {} with --force",
                            folder.string(), a_run ? "holds an earlier run" : "is not empty",
                            a_run ? "that run" : "files of the same names"));
  }
  for (const char* name : kRunFiles) fs::remove(folder / name, error);
}

}  // namespace edvo
