// SPDX-License-Identifier: MIT
#include "usage.hpp"

#include "edvo/core/did_you_mean.hpp"

#include <fmt/format.h>

namespace edvo::app {
namespace {

std::vector<std::string> verbs_of(const CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* verb : program.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(verb->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& verb) {
  std::vector<std::string> names;
  for (const CLI::Option* option : verb.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

}  // namespace

std::string explain(const CLI::App& program, const CLI::ParseError& error,
                    const std::string& first_word) {
  const auto chosen = program.get_subcommands();
  if (chosen.empty()) {
    if (first_word.empty() || first_word.starts_with('-'))
      return fmt::format("{}; see edvo --help", error.what());
    const std::vector<std::string> verbs = verbs_of(program);
    return fmt::format("unknown verb '{}'{} (known: {})", first_word,
                       did_you_mean(first_word, verbs), fmt::join(verbs, ", "));
  }
  const CLI::App& verb = *chosen.back();
  for (const std::string& word : verb.remaining()) {
    if (!word.starts_with("--")) continue;
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("unknown option '{}'{} See edvo {} --help", name,
                       did_you_mean(name, options_of(verb)), verb.get_name());
  }
  return fmt::format("{}; see edvo {} --help", error.what(), verb.get_name());
}

}  // namespace edvo::app
