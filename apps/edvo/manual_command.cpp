// SPDX-License-Identifier: MIT
// edvo manual, edvo completion: a man page and a script for bash, from what --help prints too.
#include "commands.hpp"
#include "terminal.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace edvo::app {
namespace {

std::vector<const CLI::App*> verbs_of(const CLI::App& program) {
  return program.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

// --- the man page -------------------------------------------------------------------------------

// Text as troff takes it: hyphens that can be copied, no line that is a request.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
  }
  return result;
}

// "-o, --output DIR", or a positional's name.
std::string heading_of(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames())
    names += (names.empty() ? "--" : ", --") + name;
  const bool takes_value = option.get_items_expected_max() > 0;
  const std::string type = takes_value ? option.get_type_name() : "";
  if (names.empty())
    return fmt::format("\\fI{}\\fR", escaped(type.empty() ? option.get_name() : type));
  if (type.empty()) return fmt::format("\\fB{}\\fR", escaped(names));
  return fmt::format("\\fB{}\\fR \\fI{}\\fR", escaped(names), escaped(type));
}

std::string options_page(const CLI::App& verb) {
  std::string page;
  for (const CLI::Option* const option : verb.get_options()) {
    if (option == verb.get_help_ptr()) continue;
    const std::string value = option->get_default_str();
    page += fmt::format(".TP\n{}\n{}{}\n", heading_of(*option), escaped(option->get_description()),
                        value.empty() ? "" : escaped(fmt::format(" (default {})", value)));
  }
  return page;
}

std::string verb_page(const CLI::App& verb, const std::string& name) {
  std::string page = fmt::format(".SS {}\n{}.\n", escaped(name), escaped(verb.get_description()));
  page += options_page(verb);
  for (const CLI::App* const inner : verbs_of(verb))
    page += verb_page(*inner, name + " " + inner->get_name());
  return page;
}

std::string manual(const CLI::App& program) {
  std::string page = fmt::format(
      ".TH EDVO 1\n.SH NAME\nedvo \\- {}\n.SH SYNOPSIS\n\\fBedvo\\fR \\fIVERB\\fR "
      "[\\fIOPTIONS\\fR]\n",
      escaped(program.get_description()));
  page += fmt::format(".SH OPTIONS\n{}.SH VERBS\n", options_page(program));
  for (const CLI::App* const verb : verbs_of(program)) page += verb_page(*verb, verb->get_name());
  page += fmt::format(".SH EXAMPLES\n.nf\n{}\n.fi\n", escaped(program.get_footer()));
  return page;
}

// --- bash ---------------------------------------------------------------------------------------

std::string words_of(const CLI::App& verb) {
  std::string words;
  for (const CLI::App* const inner : verbs_of(verb)) words += inner->get_name() + " ";
  for (const CLI::Option* const option : verb.get_options())
    for (const std::string& name : option->get_lnames()) words += "--" + name + " ";
  return words;
}

// "a b" of "{a,b}" in an option's type or "one of a, b" in its help; empty = anything.
std::string choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto open = type.find('{'), close = type.find('}');
  std::string list;
  if (open != std::string::npos && close != std::string::npos) {
    list = type.substr(open + 1, close - open - 1);
  } else if (const std::string& help = option.get_description(); help.starts_with("one of ")) {
    list = help.substr(std::string("one of ").size());
  }
  for (char& c : list)
    if (c == ',') c = ' ';
  return list;
}

// For other values bash completes names of files.
std::string values_script(const CLI::App& verb) {
  std::string cases;
  for (const CLI::Option* const option : verb.get_options()) {
    const std::string choices = choices_of(*option);
    if (choices.empty() || option->get_lnames().empty()) continue;
    cases += fmt::format("        --{}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n",
                         option->get_lnames().front(), choices);
  }
  return cases.empty() ? cases : fmt::format("      case $before in\n{}      esac\n", cases);
}

std::string completion(const CLI::App& program) {
  std::string script = R"(# Completion for bash; made by: edvo completion
_edvo() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} verb=
  [[ $COMP_CWORD -lt 2 ]] || verb=${COMP_WORDS[1]}
  COMPREPLY=()
  case $verb in
)";
  script += fmt::format("    '') COMPREPLY=($(compgen -W 'help {}' -- \"$word\")) ;;\n",
                        words_of(program));
  script +=
      fmt::format("    help) COMPREPLY=($(compgen -W '{}' -- \"$word\")) ;;\n", words_of(program));
  for (const CLI::App* const verb : verbs_of(program)) {
    const bool has_verbs = !verbs_of(*verb).empty();
    script += fmt::format("    {})\n{}", verb->get_name(), values_script(*verb));
    script += fmt::format("      {}COMPREPLY=($(compgen -W '{}' -- \"$word\")) ;;\n",
                          has_verbs ? "" : "[[ $word != -* ]] || ", words_of(*verb));
  }
  return script + "  esac\n}\ncomplete -o default -o bashdefault -F _edvo edvo\n";
}

}  // namespace

void add_manual_commands(CLI::App& program) {
  program.add_subcommand("completion", "Print a script that completes words of edvo in bash")
      ->callback([&program] { print_bytes(completion(program)); });
  program.add_subcommand("manual", "Print this program's man page")
      ->group("")  // for those who package it
      ->callback([&program] { print_bytes(manual(program)); });
}

}  // namespace edvo::app
