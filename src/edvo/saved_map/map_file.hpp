// SPDX-License-Identifier: MIT
// Maps on disk. Saving and loading changes no bit; docs/maps.md describes the format.
#pragma once

#include "edvo/saved_map/saved_map.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace edvo {

// Throws Error(kOutput) if the file is there and is no map, so that none may replace it.
void require_map_or_nothing(const std::filesystem::path& path);

// Replaces the file when all is on the disk; until then an older one stays, whatever happens.
// Throws Error(kOutput) naming the file, also as require_map_or_nothing() does.
void save_map(const std::filesystem::path& path, const SavedMap& map);

// Throws Error(kInput) if there is no such file, Error(kMap) naming the section if it is damaged,
// and if it is of a newer version or no map.
[[nodiscard]] SavedMap load_map(const std::filesystem::path& path);

}  // namespace edvo
