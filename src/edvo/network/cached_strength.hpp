// SPDX-License-Identifier: MIT
// A detector that remembers its answers on disk.
#pragma once

#include "edvo/features/edge_strength.hpp"

#include <functional>
#include <memory>
#include <string>

namespace edvo {

struct EdgeCache {
  std::string folder;  // exists
  // Told of entries that are damaged or cannot be written; what is asked for is computed then.
  std::function<void(const std::string& warning)> warn;
};

// Answers from the folder where the same image was seen before by a detector of the same
// fingerprint, to the last bit; else asks the detector and keeps what it says.
[[nodiscard]] std::unique_ptr<EdgeStrength> make_cached_strength(
    std::unique_ptr<EdgeStrength> source, std::string fingerprint, EdgeCache cache);

}  // namespace edvo
