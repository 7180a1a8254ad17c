// SPDX-License-Identifier: MIT
// One file from the network: resumable, of a known size, never waiting for ever.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace edvo {

struct Download {
  std::string url;           // http or https
  std::int64_t bytes = 0;    // that the file must have
  int max_lost_frames = 30;  // [s] without an answer or with next to no data
  // Told how much is there, of all bytes; false stops. From the calling thread, often.
  std::function<bool(std::int64_t done)> on_progress = {};
};

// Adds to the file what is missing of it; a server that cannot begin in the middle sends all again.
// Returns whether it is complete: false if on_progress stopped it. What has arrived stays in the
// file, for the next time. Throws Error(kModel) naming the address if it cannot be had,
// Error(kOutput) naming the file if it cannot be written or another program is writing it.
[[nodiscard]] bool download(const Download& download, const std::filesystem::path& file);

}  // namespace edvo
