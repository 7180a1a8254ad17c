// SPDX-License-Identifier: MIT
// What a host adds to the program: the Python package its sources, its viewer and its verbs.
#pragma once

#include "edvo/run/observer.hpp"
#include "edvo/source/rgbd_source.hpp"
#include "sequence_input.hpp"

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace edvo::app {

struct Extension {
  struct Option {
    std::string name;       // "--depth-topic"
    std::string type_name;  // of its value, empty = it takes none
    std::string help;
  };
  struct Verb {
    std::string name, help;
    std::function<int(const std::vector<std::string>&)> call;  // returns the exit status
  };
  using Values = std::map<std::string, std::string>;  // of the options that were given

  std::vector<Option> source_options;  // of edvo run
  std::vector<Option> watch_options;   // of edvo run and edvo demo
  std::vector<Verb> verbs;
  // Null, or a null result: the library opens it. What they throw is shown as the program's own
  // errors are.
  std::function<std::unique_ptr<RgbdSource>(const SequenceChoice&, const Values&)> open_source;
  // What looks wrong with a recording that was opened, gravest first, each with what mends it.
  // Null: no one looks.
  std::function<std::vector<std::string>(const SequenceChoice&, const Values&)> examine;
  // Where the public sequence of a name is, fetched if it is missing. Null: nothing is fetched.
  std::function<std::filesystem::path(const std::string&)> pull;
  // The values of watch_options, and of --force where it was given. A null result: no one watches.
  std::function<std::unique_ptr<Observer>(const Values&)> make_observer;
};

}  // namespace edvo::app
