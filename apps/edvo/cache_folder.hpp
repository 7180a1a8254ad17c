// SPDX-License-Identifier: MIT
// Where the program keeps what it can make again.
#pragma once

#include <filesystem>

namespace edvo::app {

// $XDG_CACHE_HOME/edvo or ~/.cache/edvo; empty if neither is known.
[[nodiscard]] std::filesystem::path cache_folder();

}  // namespace edvo::app
