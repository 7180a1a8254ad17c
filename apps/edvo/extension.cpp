// SPDX-License-Identifier: MIT
#include "extension.hpp"

#include "commands.hpp"

namespace edvo::app {

void add_extension_verb(CLI::App& program, const Extension::Verb& verb) {
  CLI::App* const command = program.add_subcommand(verb.name, verb.help);
  command->prefix_command();
  command->set_help_flag();  // --help is its own too
  command->callback([command, &verb] {
    const int status = verb.call(command->remaining());
    if (status != 0) throw CLI::RuntimeError("", status);
  });
}

void add_extension_options(CLI::App& verb, const std::vector<Extension::Option>& options,
                           Extension::Values& values) {
  for (const Extension::Option& option : options) {
    const std::string& name = option.name;
    if (option.type_name.empty()) {
      verb.add_flag_callback(
          name, [&values, name] { values[name] = "1"; }, option.help);
    } else {
      verb.add_option_function<std::string>(
              name, [&values, name](const std::string& value) { values[name] = value; },
              option.help)
          ->type_name(option.type_name);
    }
  }
}

}  // namespace edvo::app
