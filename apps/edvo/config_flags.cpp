// SPDX-License-Identifier: MIT
#include "config_flags.hpp"

#include "edvo/core/did_you_mean.hpp"
#include "edvo/io/file.hpp"
#include "enum_option.hpp"
#include "model_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace edvo::app {
namespace {

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// CANNY+CORNER is meant as it is written in lower case.
Method method_named(const std::string& word) {
  if (const std::optional<Method> method = find_named<Method>(lower_case(word))) return *method;
  const std::vector<std::string> names = names_of<Method>();
  throw Error(ErrorCode::kUsage, fmt::format("--method {}: unknown method{} (known: {})", word,
                                             did_you_mean(word, names), fmt::join(names, ", ")));
}

std::string read_text(const std::string& file) {
  constexpr std::size_t kLargestConfig = 1 << 20;  // [bytes]
  try {
    return read_stream(file, kLargestConfig);
  } catch (const Error& error) {
    const std::string reason = std::string(error.what()).substr(file.size() + 2);
    throw Error(ErrorCode::kConfig,
                fmt::format("{}: cannot read this configuration file: {}", file, reason));
  }
}

// A value that is no TOML is said to be that of the option.
void set_flag(Config& config, const std::string& assignment) {
  try {
    set_option(config, assignment);
  } catch (const Error& error) {
    if (std::string_view(error.what()).find("not valid TOML") == std::string_view::npos) throw;
    throw Error(error.code(), fmt::format("--set {}: the value is neither a number nor true or "
                                          "false; edvo config shows what the option takes",
                                          assignment));
  }
}

}  // namespace

void add_config_flags(CLI::App& verb, ConfigFlags& flags) {
  verb.add_option("--method", flags.method,
                  fmt::format("one of {}", fmt::join(names_of<Method>(), ", ")));
  verb.add_option("--config", flags.file, "TOML file; what it names replaces the method's options");
  verb.add_option(
          "--model", flags.model,
          "edge network: a description file (docs/models.md) or a name of edvo models; implies "
          "--method cnn+corner")
      ->type_name("FILE|NAME");
  verb.add_option("--set", flags.set, "group.field=value, after the file; may be repeated")
      ->take_all()
      ->expected(1);
}

Method chosen_method(const ConfigFlags& flags) {
  if (!flags.method.empty()) return method_named(flags.method);
  return flags.model.empty() ? kDefaultMethod : Method::kCnnCorner;
}

Config resolve_config(const ConfigFlags& flags) {
  Config config = preset(chosen_method(flags));
  if (!flags.file.empty()) config = config_from_toml(read_text(flags.file), flags.file, config);
  if (!flags.model.empty()) config.network.model = flags.model;
  for (const std::string& assignment : flags.set) set_flag(config, assignment);
  if (!flags.model.empty() && config.edge.detector != Detector::kNetwork)
    throw Error(ErrorCode::kUsage,
                fmt::format("--model {}: method {} uses no network; choose --method cnn+corner or "
                            "leave the model out",
                            flags.model, name_of(chosen_method(flags))));
  config.network.model = model_file(config.network.model);
  check(config);
  return config;
}

}  // namespace edvo::app
