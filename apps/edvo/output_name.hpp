// SPDX-License-Identifier: MIT
// Names of files that a verb is to write, checked before it does the work.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace edvo::app {

// Throws Error(kUsage) if the name has an ending that says another format: "--mesh room.obj".
// option: "--mesh". endings: with the point, in small letters. A name without one is fine.
void require_ending(std::string_view option, const std::string& file,
                    std::initializer_list<std::string_view> endings);

// Throws Error(kOutput) if the file cannot be written: its folder is missing or protected, or a
// folder has that name. An empty name is fine.
void require_writable(std::string_view option, const std::string& file);

// The same, and throws Error(kOutput) if the file is there, unless force. Nothing is lost with an
// empty name, an empty file, or what is no regular file (/dev/stdout).
void require_new(std::string_view option, const std::string& file, bool force);

// Pairs of option and file. Throws Error(kUsage) if two name one file; empty names are none.
void require_distinct(const std::vector<std::pair<std::string_view, std::string>>& outputs);

// require_new() of a map; what is no map is not replaced by force either.
void require_new_map(std::string_view option, const std::string& file, bool force);

}  // namespace edvo::app
