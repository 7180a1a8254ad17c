// SPDX-License-Identifier: MIT
// The cache folder of models that are ready for use: NAME.onnx and, written last, its description
// NAME.toml.
#pragma once

#include "edvo/io/model_catalogue.hpp"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace edvo {

// Names of the models whose description is there, sorted.
[[nodiscard]] std::vector<std::string> cached_models(const std::filesystem::path& folder);

// The description of the model with this name, or none.
[[nodiscard]] std::optional<std::filesystem::path> find_cached_model(
    const std::filesystem::path& folder, const std::string& name);

// Puts a known model's file into the folder, with its description, which is returned; none if the
// file is none of them, by size and SHA-256. Throws Error(kModel) if it cannot be read,
// Error(kOutput) if the folder cannot be written.
[[nodiscard]] std::optional<std::filesystem::path> import_known_model(
    const std::filesystem::path& file, const std::filesystem::path& folder,
    std::span<const KnownModel> known = known_models());

// Puts a model that is no known one into the folder, as read_model() reads it, under the name of
// its description. Throws Error(kModel) if that name is no file name, is a known model's or,
// without replace, is taken; Error(kOutput) if the folder cannot be written.
[[nodiscard]] std::filesystem::path import_model(const std::filesystem::path& description,
                                                 const std::filesystem::path& onnx,
                                                 const std::filesystem::path& folder, bool replace);

}  // namespace edvo
