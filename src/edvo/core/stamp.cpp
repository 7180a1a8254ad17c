// SPDX-License-Identifier: MIT
#include "edvo/core/stamp.hpp"

#include <charconv>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr int kMaxDecimals = 9;
constexpr double kMaxSeconds = 9.2e9;  // beyond this, nanoseconds no longer fit into 64 bits

std::optional<Stamp> parse_with_exponent(std::string_view text) {
  double seconds = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (status != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(seconds) || std::abs(seconds) >= kMaxSeconds) return std::nullopt;
  return stamp_from_seconds(seconds);
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

}  // namespace

std::optional<Stamp> parse_stamp(std::string_view text) {
  const bool negative = !text.empty() && text.front() == '-';
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
  if (text.empty() || !(is_digit(text.front()) || text.front() == '.')) return std::nullopt;

  std::int64_t seconds = 0;
  std::size_t i = 0;
  for (; i < text.size() && is_digit(text[i]); ++i) {
    seconds = seconds * 10 + (text[i] - '0');
    if (static_cast<double>(seconds) >= kMaxSeconds) return std::nullopt;
  }
  std::int64_t fraction = 0;
  int decimals = 0;
  bool round_up = false;
  if (i < text.size() && text[i] == '.') {
    const std::size_t first = ++i;
    for (; i < text.size() && is_digit(text[i]); ++i) {
      if (decimals < kMaxDecimals) {
        fraction = fraction * 10 + (text[i] - '0');
        ++decimals;
      } else if (decimals == kMaxDecimals && i == first + kMaxDecimals) {
        round_up = text[i] >= '5';
      }
    }
    if (i == 1) return std::nullopt;  // a lone point
  }
  if (i != text.size()) {
    const auto stamp = parse_with_exponent(text);
    if (!stamp || !negative) return stamp;
    return Stamp{.nanoseconds = -stamp->nanoseconds, .decimals = stamp->decimals};
  }
  for (int d = decimals; d < kMaxDecimals; ++d) fraction *= 10;
  const std::int64_t magnitude = seconds * kNanosecondsPerSecond + fraction + (round_up ? 1 : 0);
  return Stamp{.nanoseconds = negative ? -magnitude : magnitude, .decimals = decimals};
}

std::string to_string(const Stamp& stamp) {
  std::int64_t unit = 1;
  for (int d = stamp.decimals; d < kMaxDecimals; ++d) unit *= 10;
  const bool negative = stamp.nanoseconds < 0;
  const std::int64_t magnitude = negative ? -stamp.nanoseconds : stamp.nanoseconds;
  const std::int64_t seconds = magnitude / kNanosecondsPerSecond;
  std::string text = (negative ? "-" : "") + std::to_string(seconds);
  if (stamp.decimals == 0) return text;
  const std::string digits = std::to_string(magnitude % kNanosecondsPerSecond / unit);
  text += '.';
  text.append(static_cast<std::size_t>(stamp.decimals) - digits.size(), '0');
  return text + digits;
}

Stamp stamp_from_seconds(double seconds, int decimals) {
  const double scaled = std::round(seconds * std::pow(10.0, decimals));
  std::int64_t unit = 1;
  for (int d = decimals; d < kMaxDecimals; ++d) unit *= 10;
  return {.nanoseconds = static_cast<std::int64_t>(scaled) * unit, .decimals = decimals};
}

}  // namespace edvo
