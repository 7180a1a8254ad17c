// SPDX-License-Identifier: MIT
// Whole files in and out of memory, with errors that name the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace edvo {

inline constexpr std::size_t kLargestFile = std::size_t{1} << 29;  // [bytes], 512 MiB

// Throws Error(kInput) if the file is missing, not a regular file, larger than that or unreadable.
[[nodiscard]] std::string read_file(const std::filesystem::path& path,
                                    std::size_t largest = kLargestFile);

// Throws Error(kOutput) and leaves no file behind if not everything could be written.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace edvo
