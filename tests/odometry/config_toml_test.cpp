// SPDX-License-Identifier: MIT
#include "edvo/odometry/config.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <functional>

namespace edvo {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const Config kDefaults;

// The message of the kConfig error that action throws; fails the test if there is none.
std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kConfig) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "no error was thrown";
  return "";
}

std::string message_of_text(const std::string& text) {
  return message_of([&] { (void)config_from_toml(text, "my.toml", Config{}); });
}

// Calls visit(group, name, field, range) for every field there is, so that these tests hold for
// fields that do not exist yet.
template <typename AnyConfig, typename Visitor>
void for_each_field(AnyConfig& config, Visitor&& visit) {
  visit_groups(config, [&](std::string_view group, auto& options, std::string_view) {
    visit_fields(options,
                 [&](std::string_view name, auto& field, const Range& range, std::string_view) {
                   visit(std::string(group), std::string(name), field, range);
                 });
  });
}

// A legal value other than the present one, where there is one.
template <typename T>
T another(const T& value, const Range& range) {
  if constexpr (std::is_same_v<T, bool>) {
    return !value;
  } else if constexpr (std::is_same_v<T, std::string>) {
    return value + "/a \"b\" \\ c\t\x01 é";
  } else if constexpr (std::is_enum_v<T>) {
    for (const auto& [candidate, name] : EnumNames<T>::names)
      if (candidate != value) return candidate;
    return value;
  } else {
    const T lowest = static_cast<T>(std::max(range.lowest, -1000.0));
    const T highest = static_cast<T>(std::min(range.highest, 1000.0));
    const T step = static_cast<T>((highest - lowest) / 3);  // a third has no short decimal form
    return value == lowest + step ? highest : lowest + step;
  }
}

Config with_every_field_changed() {
  Config config;
  for_each_field(config, [](const auto&, const auto&, auto& field, const Range& range) {
    field = another(field, range);
  });
  return config;
}

TEST(ConfigToml, SurvivesARoundTrip) {
  const Config changed = with_every_field_changed();
  const std::string text = to_toml(changed);
  EXPECT_EQ(to_toml(config_from_toml(text, "round trip", Config{})), text);
  EXPECT_NE(text, to_toml(Config{}));
}

TEST(ConfigToml, KeepsWhatTheTextDoesNotName) {
  const Config changed = with_every_field_changed();
  EXPECT_EQ(to_toml(config_from_toml("", "empty", changed)), to_toml(changed));
}

TEST(ConfigToml, OneFieldReadIsOneFieldChanged) {
  const Config changed = with_every_field_changed();
  for_each_field(changed, [&](const auto& group, const auto& name, const auto& field, auto) {
    Config config;
    const std::string text = to_toml(changed);
    const std::size_t section = text.find("[" + group + "]");
    const std::size_t line = text.find("\n" + name + " = ", section) + 1;
    const std::string assignment = text.substr(line, text.find('\n', line) - line);
    config = config_from_toml("[" + group + "]\n" + assignment, "one line", config);
    Config set;
    set_option(set, group + "." + assignment);
    EXPECT_EQ(to_toml(set), to_toml(config)) << assignment;
    for_each_field(config, [&](const auto& g, const auto& n, const auto& now, auto) {
      if constexpr (std::is_same_v<decltype(now), decltype(field)>)
        if (g == group && n == name) {
          EXPECT_EQ(now, field) << assignment;
        }
    });
  });
}

TEST(ConfigToml, SaysHelpAndRangeAboveEachField) {
  const std::string text = to_toml(Config{});
  EXPECT_THAT(text, HasSubstr("; allowed: 0 to 50\nkeyframes = "));
  std::size_t fields = 0;
  std::size_t comments = 0;
  for_each_field(kDefaults, [&](auto&&...) { ++fields; });
  for (std::size_t i = text.find("\n# "); i != std::string::npos; i = text.find("\n# ", i + 1))
    ++comments;
  EXPECT_GE(comments, fields);
}

TEST(ConfigToml, RefusesWrongTypesInEveryField) {
  for_each_field(kDefaults, [](const auto& group, const auto& name, const auto& field, auto) {
    constexpr bool is_text = !std::is_arithmetic_v<std::remove_cvref_t<decltype(field)>>;
    for (const std::string& value : {std::string(is_text ? "3" : "\"three\""), std::string("[1]"),
                                     std::string("{a = 1}"), std::string("1979-05-27")}) {
      const std::string text = fmt::format("[{}]\n\n{} = {}\n", group, name, value);
      EXPECT_THAT(message_of_text(text),
                  AllOf(HasSubstr(fmt::format("my.toml:3: {}.{} = ", group, name)),
                        HasSubstr("expected"), HasSubstr("allowed: ")));
    }
  });
}

TEST(ConfigToml, RefusesNumbersOutOfRangeInEveryField) {
  for_each_field(
      kDefaults, [](const auto& group, const auto& name, const auto& field, const Range& range) {
        using Field = std::remove_cvref_t<decltype(field)>;
        if constexpr (std::is_same_v<Field, int> || std::is_same_v<Field, double>) {
          std::vector<std::string> values;
          if (std::is_same_v<Field, double>) values = {"nan", "-nan"};
          if (std::is_same_v<Field, int>) values = {"99999999999", "-99999999999"};
          if (std::abs(range.lowest) < 1e9)
            values.push_back(fmt::format("{:.0f}", range.lowest - 1));
          if (std::abs(range.highest) < 1e9)
            values.push_back(fmt::format("{:.0f}", range.highest + 1));
          for (const std::string& value : values) {
            const std::string key = group + "." + name;
            EXPECT_THAT(message_of_text(key + " = " + value),
                        AllOf(HasSubstr("my.toml:1: " + key + " = "), HasSubstr("out of range")));
            Config config;
            EXPECT_THAT(message_of([&] { set_option(config, key + "=" + value); }),
                        HasSubstr("out of range"));
            EXPECT_EQ(to_toml(config), to_toml(Config{})) << "a refused value was kept";
          }
        }
      });
}

TEST(ConfigToml, RefusesUnknownNamesInEveryEnumAndListsTheKnownOnes) {
  for_each_field(kDefaults, [](const auto& group, const auto& name, const auto& field, auto) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (std::is_enum_v<Field>) {
      const std::string message = message_of_text(fmt::format("{}.{} = \"nonsense\"", group, name));
      EXPECT_THAT(message, HasSubstr("\"nonsense\": unknown value"));
      for (const auto& [value, spelling] : EnumNames<Field>::names)
        EXPECT_THAT(message, HasSubstr(std::string(spelling)));
    }
  });
}

TEST(ConfigToml, TakesWholeNumbersWhereAFractionIsWanted) {
  for_each_field(
      kDefaults, [](const auto& group, const auto& name, const auto& field, const Range& range) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(field)>, double>) {
          const double whole = std::ceil(std::max(range.lowest, -1000.0));
          if (whole > range.highest) return;
          EXPECT_NO_THROW((void)config_from_toml(fmt::format("{}.{} = {:.0f}", group, name, whole),
                                                 "whole number", Config{}));
        }
      });
}

TEST(ConfigToml, NamesTheNearestKeyToAnUnknownOne) {
  EXPECT_EQ(message_of_text("\n[window]\nkeyframe = 3"),
            "my.toml:3: unknown key 'window.keyframe', did you mean 'window.keyframes'?");
  EXPECT_EQ(message_of_text("[windo]\nkeyframes = 3"),
            "my.toml:2: unknown key 'windo.keyframes', did you mean 'window.keyframes'?");
  EXPECT_EQ(message_of_text("[nowhere]\nsomething = 3"),
            "my.toml:2: unknown key 'nowhere.something'");
  EXPECT_THAT(message_of_text("[nowhere]"), HasSubstr("my.toml:1: unknown key 'nowhere'"));
  EXPECT_THAT(message_of_text("window = 3"), HasSubstr("my.toml:1: unknown key 'window'"));
}

TEST(ConfigToml, SaysWhatBecameOfKeysOfEarlierVersions) {
  EXPECT_EQ(message_of_text("[window]\nanchors = 3"),
            "my.toml:2: 'window.anchors' is called 'window.fixed_keyframes' now");
  EXPECT_THAT(message_of_text("[frame]\nlevels = 3"),
              HasSubstr("my.toml:2: 'frame.levels' is no option any more"));
}

TEST(ConfigToml, AFieldWithoutItsGroupIsUnknownButNamed) {
  EXPECT_THAT(message_of_text("max_points = 3"),
              HasSubstr("unknown key 'max_points', did you mean '"));
}

TEST(ConfigToml, RefusesTextThatIsNotToml) {
  EXPECT_THAT(message_of_text("[window]\nkeyframes 3"), HasSubstr("my.toml:2: not valid TOML: "));
  EXPECT_THAT(message_of_text("window.keyframes = 3\nwindow.keyframes = 4"),
              HasSubstr("my.toml:2: not valid TOML: "));
}

TEST(SetOption, TakesStringsAndEnumsWithOrWithoutQuotes) {
  for_each_field(kDefaults,
                 [](const auto& group, const auto& name, const auto& field, const Range& range) {
                   using Field = std::remove_cvref_t<decltype(field)>;
                   std::string value;
                   if constexpr (std::is_same_v<Field, std::string>)
                     value = "some/path with spaces.toml";
                   if constexpr (std::is_enum_v<Field>) value = name_of(another(field, range));
                   if (value.empty()) return;
                   Config bare;
                   Config in_quotes;
                   set_option(bare, fmt::format("{}.{}={}", group, name, value));
                   set_option(in_quotes, fmt::format(" {}.{} = \"{}\" ", group, name, value));
                   EXPECT_EQ(to_toml(bare), to_toml(in_quotes));
                   EXPECT_NE(to_toml(bare), to_toml(Config{}));
                 });
}

TEST(SetOption, RefusesWhatIsNotOneAssignmentToAKnownKey) {
  Config config;
  EXPECT_EQ(message_of([&] { set_option(config, "window.keyframes"); }),
            "'window.keyframes': expected group.field=value");
  EXPECT_EQ(message_of([&] { set_option(config, "window.keyframse=3"); }),
            "unknown key 'window.keyframse', did you mean 'window.keyframes'?");
  EXPECT_THAT(message_of([&] { set_option(config, "window.keyframes="); }),
              HasSubstr("window.keyframes"));
  EXPECT_THAT(message_of([&] { set_option(config, "window.keyframes=3\nx=4"); }),
              HasSubstr("window.keyframes"));
  EXPECT_THAT(message_of([&] { set_option(config, "window.keyframes=3.5"); }),
              HasSubstr("window.keyframes = 3.5: expected a whole number, allowed: 0 to 50"));
}

TEST(CheckConfig, AcceptsTheDefaults) {
  EXPECT_NO_THROW(check(Config{}));
  EXPECT_NO_THROW(check(with_every_field_changed()));
}

TEST(CheckConfig, RefusesValuesThatWereSetInCode) {
  Config config;
  config.window.keyframes = 99;
  EXPECT_EQ(message_of([&] { check(config); }),
            "window.keyframes = 99: out of range, allowed: 0 to 50");
  for_each_field(config, [](const auto&, const auto&, auto& field, auto) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(field)>, double>) {
      field = std::nan("");
    }
  });
  EXPECT_NE(message_of([&] { check(config); }), "");
}

}  // namespace
}  // namespace edvo
