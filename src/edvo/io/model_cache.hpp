// SPDX-License-Identifier: MIT
// The folder in which models lie ready for use: NAME.onnx and, written last, its description
// NAME.toml.
#pragma once

#include "edvo/io/model_catalogue.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace edvo {

// Names of the models whose description is there, sorted.
[[nodiscard]] std::vector<std::string> cached_models(const std::filesystem::path& folder);

// The description of the model with this name, or none.
[[nodiscard]] std::optional<std::filesystem::path> find_cached_model(
    const std::filesystem::path& folder, const std::string& name);

struct PullOptions {
  std::string address;       // instead of the known ones
  int max_lost_frames = 30;  // [s] without an answer or with next to no data
  std::function<bool(std::int64_t done)> on_progress = {};  // [bytes]; false stops
  std::function<void(const std::string& note)> on_note = {};
};

// Its description, once its file is there and has the right hash; what is whole is not fetched
// again, what is begun goes on. None if on_progress stopped it. Throws Error(kModel) if it cannot
// be had or is not what it should be, which is then not kept; Error(kOutput) if the folder cannot
// be written.
[[nodiscard]] std::optional<std::filesystem::path> pull_model(const KnownModel& model,
                                                              const std::filesystem::path& folder,
                                                              const PullOptions& options);

// The same from a file that is already here.
[[nodiscard]] std::filesystem::path pull_model_from(const KnownModel& model,
                                                    const std::filesystem::path& folder,
                                                    const std::filesystem::path& file);

// Puts a model that is no known one into the folder, as read_model() reads it, under the name of
// its description. Throws Error(kModel) if that name is no file name, is a known model's or,
// without replace, is taken; Error(kOutput) if the folder cannot be written.
[[nodiscard]] std::filesystem::path import_model(const std::filesystem::path& description,
                                                 const std::filesystem::path& onnx,
                                                 const std::filesystem::path& folder, bool replace);

}  // namespace edvo
