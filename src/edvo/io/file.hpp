// SPDX-License-Identifier: MIT
// Whole files in and out of memory, with errors that name the file.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace edvo {

inline constexpr std::size_t kLargestFile = std::size_t{1} << 29;  // [bytes], 512 MiB

// Throws Error(kInput) if the file is missing, not a regular file, larger than that or unreadable.
[[nodiscard]] std::string read_file(const std::filesystem::path& path,
                                    std::size_t largest = kLargestFile);

// The same of a pipe or a device, too, as `--config <(make_config)` gives one. Throws also where
// nothing arrives for so long.
[[nodiscard]] std::string read_stream(
    const std::filesystem::path& path, std::size_t largest,
    std::chrono::milliseconds patience = std::chrono::seconds(10));

// Throws Error(kOutput) and leaves no file behind if not everything could be written.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace edvo
