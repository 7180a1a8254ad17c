// SPDX-License-Identifier: MIT
// The fingerprint by which a model file is known (FIPS 180-4).
#pragma once

#include <string>
#include <string_view>

namespace edvo {

// 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256(std::string_view bytes);

}  // namespace edvo
