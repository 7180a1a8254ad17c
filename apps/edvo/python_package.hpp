// SPDX-License-Identifier: MIT
// What only the Python package can do, for those who ask the C++ program for it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace edvo::app {

// A sentence for a verb or an option ("--view") that only the package has; none for others.
[[nodiscard]] std::optional<std::string> said_of_package(const std::string& verb_or_option);

// Throws Error(kUsage) if the package reads what is there and this program does not: a bag, a
// phone's recording, a camera.
void refuse_what_package_reads(const std::filesystem::path& sequence);

}  // namespace edvo::app
