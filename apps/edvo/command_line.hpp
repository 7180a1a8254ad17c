// SPDX-License-Identifier: MIT
// The command as it was given, to be given again.
#pragma once

#include <string>

namespace edvo::app {

// The arguments of this process, quoted where a shell would otherwise take them apart.
[[nodiscard]] std::string this_command();

[[nodiscard]] std::string shell_quoted(const std::string& argument);

}  // namespace edvo::app
