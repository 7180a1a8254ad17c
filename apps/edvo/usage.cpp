// SPDX-License-Identifier: MIT
#include "usage.hpp"

#include "edvo/core/did_you_mean.hpp"
#include "python_package.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace edvo::app {
namespace {

std::vector<std::string> verbs_of(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* verb :
       program.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); }))
    names.push_back(verb->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& verb) {
  std::vector<std::string> names;
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

bool has_package(const CLI::App& program) {
  const std::vector<std::string> verbs = verbs_of(program);
  return std::ranges::find(verbs, "pull") != verbs.end();
}

}  // namespace

std::string explain(const CLI::App& program, const CLI::ParseError& error,
                    const std::string& first_word) {
  const auto chosen = program.get_subcommands();
  if (chosen.empty()) {
    const std::vector<std::string> verbs = verbs_of(program);
    if (first_word.empty())
      return fmt::format("what shall it do? ({}); see edvo --help", fmt::join(verbs, ", "));
    if (first_word.starts_with('-'))
      return fmt::format("unknown option '{}'{} See edvo --help", first_word,
                         did_you_mean(first_word, options_of(program)));
    if (const auto said = said_of_package(first_word)) return *said;
    return fmt::format("unknown verb '{}'{} (known: {})", first_word,
                       did_you_mean(first_word, verbs), fmt::join(verbs, ", "));
  }
  const CLI::App* verb = chosen.back();
  std::string name = verb->get_name();
  while (!verb->get_subcommands().empty()) {
    verb = verb->get_subcommands().back();
    name += " " + verb->get_name();
  }
  const std::vector<std::string> words = verb->remaining();
  if (const std::vector<std::string> verbs = verbs_of(*verb); !verbs.empty()) {
    const std::string known = fmt::format("(known: {})", fmt::join(verbs, ", "));
    if (words.empty()) return fmt::format("{} needs a verb {}", name, known);
    return fmt::format("unknown verb '{} {}'{} {}", name, words.front(),
                       did_you_mean(words.front(), verbs), known);
  }
  for (const std::string& word : words) {
    if (!word.starts_with("--")) continue;
    const std::string option = word.substr(0, word.find('='));
    const bool is_of_run = name == "run" || name == "demo";
    if (const auto said = said_of_package(option); said && is_of_run && !has_package(program))
      return *said;
    return fmt::format("unknown option '{}'{} See edvo {} --help", option,
                       did_you_mean(option, options_of(*verb)), name);
  }
  for (const CLI::Option* option : verb->get_options())
    if (option->count() > 1 && option->get_items_expected_max() == 1)
      return fmt::format("{} is given {} times ({}); it takes one value", option->get_name(),
                         option->count(), fmt::join(option->results(), ", "));
  return fmt::format("{}; see edvo {} --help", error.what(), name);
}

}  // namespace edvo::app
