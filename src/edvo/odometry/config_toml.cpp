// SPDX-License-Identifier: MIT
#include "edvo/core/did_you_mean.hpp"
#include "edvo/core/find_named.hpp"
#include "edvo/core/parse_toml.hpp"
#include "edvo/odometry/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace edvo {
namespace {

// place: where the value was written, "file.toml:17: track.levels", or only the key.
[[noreturn]] void refuse(const std::string& place, const std::string& value,
                         const std::string& want) {
  throw Error(ErrorCode::kConfig, fmt::format("{} = {}: {}", place, value, want));
}

// --- what a field may be ------------------------------------------------------------------------

std::string interval(const Range& range) {
  const bool from = std::isfinite(range.lowest);
  const bool to = std::isfinite(range.highest);
  if (from && to) return fmt::format("{} to {}", range.lowest, range.highest);
  if (from) return fmt::format("at least {}", range.lowest);
  if (to) return fmt::format("at most {}", range.highest);
  return "any number";
}

template <typename T>
std::string allowed(const T&, const Range& range) {
  if constexpr (std::is_same_v<T, bool>) {
    return "true or false";
  } else if constexpr (std::is_same_v<T, std::string>) {
    return "text";
  } else if constexpr (std::is_enum_v<T>) {
    std::string names;
    for (const auto& [value, name] : EnumNames<T>::names)
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", name);
    return "one of " + names;
  } else {
    return interval(range);
  }
}

// --- writing ------------------------------------------------------------------------------------

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

template <typename T>
std::string spelled(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return quoted(name_of(value));
  } else if constexpr (std::is_same_v<T, std::string>) {
    return quoted(value);
  } else if constexpr (std::is_same_v<T, double>) {
    const std::string text = fmt::format("{}", value);  // fewest digits that read back the same
    const bool looks_whole = text.find_first_not_of("-0123456789") == std::string::npos;
    return looks_whole ? text + ".0" : text;
  } else {
    return fmt::format("{}", value);  // bool, int
  }
}

std::string spelled_in_toml(const toml::node& node) {
  std::ostringstream out;
  node.visit([&out](const auto& value) { out << value; });
  return out.str();
}

// --- checking and reading one field -------------------------------------------------------------

template <typename T>
void check_field(const T& value, const Range& range, const std::string& place) {
  bool fits = true;
  if constexpr (std::is_enum_v<T>) {
    fits = name_of(value) != "?";
  } else if constexpr (std::is_same_v<T, int> || std::is_same_v<T, double>) {
    fits = value >= range.lowest && value <= range.highest;  // NaN does not
  }
  if (!fits) refuse(place, spelled(value), "out of range, allowed: " + allowed(value, range));
}

template <typename T>
std::string kind() {
  if constexpr (std::is_same_v<T, bool>) return "true or false";
  if constexpr (std::is_same_v<T, int>) return "a whole number";
  if constexpr (std::is_same_v<T, double>) return "a number";
  return "text in quotes";
}

// The node's value as T; empty where the node is of another type.
template <typename T>
std::optional<T> value_as(const toml::node& node) {
  if constexpr (std::is_same_v<T, double>) {
    if (const auto* integer = node.as_integer()) return static_cast<double>(integer->get());
    if (const auto* floating = node.as_floating_point()) return floating->get();
  } else {
    if (const auto* exact = node.as<T>()) return exact->get();
  }
  return std::nullopt;
}

template <typename T>
void read_field(T& field, const Range& range, const toml::node& node, const std::string& place) {
  const auto wrong_type = [&] {
    refuse(place, spelled_in_toml(node),
           fmt::format("expected {}, allowed: {}", kind<T>(), allowed(field, range)));
  };
  if constexpr (std::is_enum_v<T>) {
    const auto text = value_as<std::string>(node);
    if (!text) wrong_type();
    const auto value = find_named<T>(*text);
    if (!value) refuse(place, quoted(*text), "unknown value, allowed: " + allowed(field, range));
    field = *value;
  } else if constexpr (std::is_same_v<T, int>) {
    const auto integer = value_as<std::int64_t>(node);
    if (!integer) wrong_type();
    const int value = static_cast<int>(*integer);
    if (value != *integer)
      refuse(place, fmt::format("{}", *integer), "out of range, allowed: " + interval(range));
    check_field(value, range, place);
    field = value;
  } else {
    const auto value = value_as<T>(node);
    if (!value) wrong_type();
    check_field(*value, range, place);
    field = *value;
  }
}

// --- keys ---------------------------------------------------------------------------------------

// Calls visit(key "group.field", field, range, help) for every field.
template <typename AnyConfig, typename Visitor>
void visit_all(AnyConfig& config, Visitor&& visit) {
  visit_groups(config, [&](std::string_view group, auto& options, std::string_view) {
    visit_fields(options, [&](std::string_view name, auto& field, const Range& range,
                              std::string_view help) {
      visit(fmt::format("{}.{}", group, name), field, range, help);
    });
  });
}

std::vector<std::string> all_keys(const Config& config) {
  std::vector<std::string> keys;
  visit_all(config,
            [&](const std::string& key, const auto&, const Range&, auto) { keys.push_back(key); });
  return keys;
}

bool is_group(const Config& config, std::string_view word) {
  bool found = false;
  visit_groups(config, [&](std::string_view group, const auto&, auto) { found |= group == word; });
  return found;
}

// A field without its group is the likelier slip than a misspelled one.
std::string hint(std::string_view word, const std::vector<std::string>& keys) {
  for (const std::string& key : keys)
    if (key.substr(key.find('.') + 1) == word) return fmt::format(", did you mean '{}'?", key);
  return did_you_mean(word, keys);
}

// Keys of version 0.1 that have another name now, or none.
constexpr auto kFormerKeys = std::to_array<std::pair<std::string_view, std::string_view>>({
    {"coarse.acceleration", "motion.acceleration"},
    {"keyframes.patience", "keyframes.max_lost_frames"},
    {"network.influence", "network.edge_exponent"},
    {"tracking.geometric", "tracking.depth_weight"},
    {"window.anchors", "window.fixed_keyframes"},
    {"window.geometric", "window.depth_weight"},
    {"window.memory", "window.candidate_keyframes"},
    {"canny.blur_sigma", ""},
    {"canny.low_ratio", ""},
    {"coarse.coarsest_level", ""},
    {"coarse.enabled", ""},
    {"coarse.finest_level", ""},
    {"coarse.second_look", ""},
    {"coarse.step", ""},
    {"corners.budget", ""},
    {"corners.min_distance", ""},
    {"corners.strict_quality", ""},
    {"corners.window_sigma", ""},
    {"frame.levels", ""},
    {"keyframes.inliers", ""},
    {"keyframes.sharper", ""},
    {"network.blur_sigma", ""},
    {"network.edge_share", ""},
    {"network.low_ratio", ""},
    {"selection.cell", ""},
    {"selection.foreground", ""},
    {"selection.jump", ""},
    {"selection.jump_radius", ""},
    {"selection.min_points", ""},
    {"tracking.edge_distance", ""},
    {"tracking.edge_sigma", ""},
    {"tracking.max_iterations", ""},
    {"tracking.min_correlation", ""},
    {"tracking.min_inliers", ""},
    {"tracking.min_overlap", ""},
    {"tracking.softness", ""},
    {"tracking.step_tolerance", ""},
    {"tracking.surface_cell", ""},
    {"window.depth_bias", ""},
    {"window.huber", ""},
    {"window.iterations", ""},
    {"window.own_sigma", ""},
    {"window.sigma", ""},
    {"window.softness", ""},
    {"window.tolerance", ""},
});

[[noreturn]] void refuse_key(const std::string& where, std::string_view key, const Config& config) {
  const auto former =
      std::ranges::find(kFormerKeys, key, &std::pair<std::string_view, std::string_view>::first);
  if (former != kFormerKeys.end() && former->second.empty())
    throw Error(ErrorCode::kConfig,
                fmt::format("{}'{}' is no option any more: its value is a constant now "
                            "(docs/experiments/options.md); leave the line out",
                            where, key));
  if (former != kFormerKeys.end())
    throw Error(ErrorCode::kConfig,
                fmt::format("{}'{}' is called '{}' now", where, key, former->second));
  throw Error(ErrorCode::kConfig,
              fmt::format("{}unknown key '{}'{}", where, key, hint(key, all_keys(config))));
}

void read_key(Config& config, const std::string& key, const toml::node& node,
              const std::string& where) {
  bool known = false;
  visit_all(config, [&](const std::string& candidate, auto& field, const Range& range, auto) {
    if (candidate != key) return;
    known = true;
    read_field(field, range, node, where + key);
  });
  if (!known) refuse_key(where, key, config);
}

std::string line_of(const toml::node& node, const std::string& source) {
  return fmt::format("{}:{}: ", source, node.source().begin.line);
}

}  // namespace

std::string to_toml(const Config& config) {
  std::string text;
  visit_groups(config, [&](std::string_view group, const auto& options, std::string_view about) {
    text += fmt::format("{}# {}\n[{}]\n", text.empty() ? "" : "\n", about, group);
    visit_fields(options, [&](std::string_view name, const auto& field, const Range& range,
                              std::string_view help) {
      text += fmt::format("# {}; allowed: {}\n{} = {}\n", help, allowed(field, range), name,
                          spelled(field));
    });
  });
  return text;
}

Config config_from_toml(std::string_view text, const std::string& source, Config base) {
  const toml::table root = parse_toml(text, source, ErrorCode::kConfig);
  for (const auto& [group, options] : root) {
    const toml::table* fields = options.as_table();
    const bool is_empty_group = fields && fields->empty() && is_group(base, group.str());
    if (is_empty_group) continue;
    if (!fields || fields->empty()) refuse_key(line_of(options, source), group.str(), base);
    for (const auto& [name, node] : *fields)
      read_key(base, fmt::format("{}.{}", group.str(), name.str()), node, line_of(node, source));
  }
  return base;
}

void set_option(Config& config, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos)
    throw Error(ErrorCode::kConfig, fmt::format("'{}': expected group.field=value", assignment));
  const auto trimmed = [](std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return std::string();
    return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
  };
  const std::string key = trimmed(assignment.substr(0, equals));
  const std::string value = trimmed(assignment.substr(equals + 1));

  bool known = false;
  visit_all(config, [&](const std::string& candidate, auto& field, const Range& range, auto) {
    if (candidate != key) return;
    known = true;
    using Field = std::remove_cvref_t<decltype(field)>;
    constexpr bool is_text = std::is_enum_v<Field> || std::is_same_v<Field, std::string>;
    const bool bare = is_text && !value.starts_with('"') && !value.starts_with('\'');
    const std::string source = fmt::format("value of {}", key);
    const toml::table table =
        parse_toml("value = " + (bare ? quoted(value) : value), source, ErrorCode::kConfig);
    if (table.size() != 1) refuse(key, value, "expected one value");
    read_field(field, range, *table.get("value"), key);
  });
  if (!known) refuse_key("", key, config);
}

void check(const Config& config) {
  visit_all(config, [](const std::string& key, const auto& field, const Range& range, auto) {
    check_field(field, range, key);
  });
}

}  // namespace edvo
