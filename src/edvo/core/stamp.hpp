// SPDX-License-Identifier: MIT
// Time stamps that are written exactly as they were read: integer nanoseconds and a number of
// decimals.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace edvo {

// A point in time. A double would lose digits of "1305031102.175304"; text would not order.
struct Stamp {
  std::int64_t nanoseconds = 0;
  int decimals = 6;  // [0..9], digits after the point, so that to_string() writes what was read

  friend bool operator==(const Stamp& a, const Stamp& b) { return a.nanoseconds == b.nanoseconds; }
  friend auto operator<=>(const Stamp& a, const Stamp& b) {
    return a.nanoseconds <=> b.nanoseconds;
  }
};

// Parses "1305031102.175304" (optional sign, optional fraction, optional exponent). Digits past the
// ninth decimal are rounded. None if the text is not a finite number or out of range.
[[nodiscard]] std::optional<Stamp> parse_stamp(std::string_view text);

[[nodiscard]] std::string to_string(const Stamp& stamp);

[[nodiscard]] Stamp stamp_from_seconds(double seconds, int decimals = 6);  // [s]

[[nodiscard]] inline double to_seconds(const Stamp& stamp) {  // [s]
  return static_cast<double>(stamp.nanoseconds) * 1e-9;
}

// later - earlier [s]; the difference is exact before it is converted to double.
[[nodiscard]] inline double seconds_between(const Stamp& earlier, const Stamp& later) {
  return static_cast<double>(later.nanoseconds - earlier.nanoseconds) * 1e-9;
}

}  // namespace edvo
