// SPDX-License-Identifier: MIT
// Reads and writes whole files; errors name the file.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace edvo {

inline constexpr std::size_t kLargestFile = std::size_t{1} << 29;  // [bytes], 512 MiB

// Throws Error(kInput) if the file is missing, not a regular file, larger than `largest` [bytes] or
// unreadable.
[[nodiscard]] std::string read_file(const std::filesystem::path& path,
                                    std::size_t largest = kLargestFile);

// The same for a regular file, a pipe or a device (`--config <(make_config)`). Throws Error(kInput)
// also if no data arrive for longer than patience.
[[nodiscard]] std::string read_stream(
    const std::filesystem::path& path, std::size_t largest,
    std::chrono::milliseconds patience = std::chrono::seconds(10));

// Throws Error(kOutput) and leaves no file behind if not everything could be written.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace edvo
