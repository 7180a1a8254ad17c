// SPDX-License-Identifier: MIT
// Models by name: those that `edvo models` has put into the cache.
#pragma once

#include <filesystem>
#include <string>

namespace edvo::app {

// Throws Error(kModel) if no cache folder is known.
[[nodiscard]] std::filesystem::path models_folder();

// The step that brings a known model into the cache, as half a sentence.
[[nodiscard]] std::string how_to_get(const std::string& known);

// The description that --model means: a file, or the name of a model in the cache. Throws
// Error(kModel), with how to get it, for the name of a known model that is not there; other words
// are returned as they are.
[[nodiscard]] std::string model_file(const std::string& file_or_name);

}  // namespace edvo::app
