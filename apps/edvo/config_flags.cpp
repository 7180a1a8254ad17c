// SPDX-License-Identifier: MIT
#include "config_flags.hpp"

#include "edvo/core/did_you_mean.hpp"
#include "enum_option.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace edvo::app {
namespace {

Method method_named(const std::string& word) {
  if (const std::optional<Method> method = find_named<Method>(word)) return *method;
  const std::vector<std::string> names = names_of<Method>();
  throw Error(ErrorCode::kUsage, fmt::format("--method {}: unknown method{} (known: {})", word,
                                             did_you_mean(word, names), fmt::join(names, ", ")));
}

std::string read_text(const std::string& file) {
  std::error_code ignored;
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file, ignored))
    throw Error(ErrorCode::kConfig, fmt::format("{}: cannot read this configuration file", file));
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

void add_config_flags(CLI::App& verb, ConfigFlags& flags) {
  verb.add_option("--method", flags.method,
                  fmt::format("one of {}", fmt::join(names_of<Method>(), ", ")));
  verb.add_option("--config", flags.file, "TOML file; what it names replaces the method's options");
  verb.add_option("--model", flags.model,
                  "description of an edge network (docs/models.md); implies --method cnn+corner")
      ->type_name("FILE");
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
  for (const std::string& assignment : flags.set) set_option(config, assignment);
  if (!flags.model.empty() && config.edge.detector != Detector::kNetwork)
    throw Error(ErrorCode::kUsage,
                fmt::format("--model {}: method {} uses no network; choose --method cnn+corner or "
                            "leave the model out",
                            flags.model, name_of(chosen_method(flags))));
  check(config);
  return config;
}

}  // namespace edvo::app
