// SPDX-License-Identifier: MIT
// How an options struct lists its fields once, for configuration files, command line and checks.
//
// Beside each options struct stands one function template:
//
//   template <typename Self, typename Visitor>
//     requires std::same_as<std::remove_const_t<Self>, HuberOptions>
//   void visit_fields(Self& self, Visitor&& visit) {
//     visit("delta", self.delta, Range{0, 1e6}, "threshold theta_H [residual sigmas] (Eq. 6)");
//   }
//
// A field is a bool, int, double, std::string or an enum with enum_names(); a nested options struct
// is visited with a group name: visit_group("huber", self.huber).
#pragma once

#include "edvo/core/error.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace edvo {

// Closed interval of allowed values; ignored for bool, string and enum fields.
struct Range {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

// The spelling of an enum's values. Specialise with: static constexpr auto names =
// std::to_array<std::pair<E, std::string_view>>({{E::kA, "a"}, ...});
template <typename Enum>
struct EnumNames;

template <typename Enum>
[[nodiscard]] std::string_view name_of(Enum value) {
  for (const auto& [candidate, name] : EnumNames<Enum>::names)
    if (candidate == value) return name;
  return "?";
}

}  // namespace edvo
