// SPDX-License-Identifier: MIT
#include "edvo/eval/rpe.hpp"

#include "edvo/core/error.hpp"

#include <fmt/core.h>

#include <array>
#include <charconv>
#include <cmath>

namespace edvo {
namespace {

struct UnitName {
  DeltaUnit unit;
  std::string_view suffix;  // as in "30f"
  std::string_view one;     // "m/frame"
  std::string_view many;    // "m per 30 frames"
};

constexpr std::array<UnitName, 5> kUnits = {{{DeltaUnit::kSeconds, "s", "s", "s"},
                                             {DeltaUnit::kFrames, "f", "frame", "frames"},
                                             {DeltaUnit::kMetres, "m", "m", "m"},
                                             {DeltaUnit::kRadians, "rad", "rad", "rad"},
                                             {DeltaUnit::kDegrees, "deg", "deg", "deg"}}};
constexpr std::string_view kAll = "all";

const UnitName& unit_name(DeltaUnit unit) {
  for (const UnitName& name : kUnits)
    if (name.unit == unit) return name;
  throw Error(ErrorCode::kInternal, "delta without a unit name");
}

}  // namespace

Delta parse_delta(std::string_view text) {
  if (text == kAll) return {.value = 0, .unit = DeltaUnit::kAllPairs};
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc{} && std::isfinite(value) && value > 0)
    for (const UnitName& name : kUnits)
      if (std::string_view(end, static_cast<std::size_t>(text.data() + text.size() - end)) ==
          name.suffix)
        return {.value = value, .unit = name.unit};
  throw Error(ErrorCode::kUsage,
              fmt::format("delta \"{}\" is not one of 1s, 30f, 0.5m, 0.1rad, 10deg, all", text));
}

std::string to_string(const Delta& delta) {
  if (delta.unit == DeltaUnit::kAllPairs) return std::string(kAll);
  return fmt::format("{}{}", delta.value, unit_name(delta.unit).suffix);
}

std::string per_delta(const Delta& delta) {
  if (delta.unit == DeltaUnit::kAllPairs) return " over all pairs";
  const UnitName& name = unit_name(delta.unit);
  if (delta.value == 1) return fmt::format("/{}", name.one);
  return fmt::format(" per {} {}", delta.value, name.many);
}

}  // namespace edvo
