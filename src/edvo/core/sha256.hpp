// SPDX-License-Identifier: MIT
// SHA-256 (FIPS 180-4), which identifies model files and cached edge maps.
#pragma once

#include <string>
#include <string_view>

namespace edvo {

// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace edvo
