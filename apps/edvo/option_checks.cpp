// SPDX-License-Identifier: MIT
#include "option_checks.hpp"

#include <fmt/core.h>

#include <string>

namespace edvo::app {

CLI::Validator number_between(double lowest, double highest) {
  const auto complaint = [lowest, highest](const std::string& text) -> std::string {
    double value = 0;
    const bool is_number = CLI::detail::lexical_cast(text, value);
    if (is_number && value >= lowest && value <= highest) return {};
    return fmt::format("{} is no number from {} to {}", text, lowest, highest);
  };
  return {complaint, fmt::format("in [{} - {}]", lowest, highest)};
}

void refuse_empty_values(CLI::App& program) {
  const auto complaint = [](const std::string& text) -> std::string {
    return text.empty() ? "the value is empty" : "";
  };
  for (CLI::Option* option : program.get_options())
    if (option->get_items_expected_max() > 0) option->check(CLI::Validator(complaint, ""));
  for (CLI::App* verb : program.get_subcommands([](const CLI::App*) { return true; }))
    refuse_empty_values(*verb);
}

}  // namespace edvo::app
