// SPDX-License-Identifier: MIT
// An edge network on disk: its description and its weights.
#pragma once

#include "edvo/io/file.hpp"
#include "edvo/io/model_description.hpp"

#include <filesystem>
#include <string>

namespace edvo {

struct Model {
  ModelDescription description;
  std::string weights;  // bytes of the ONNX file
  std::string source;   // the ONNX file's path, for messages
};

// Throws Error(kModel) if one of the two files is missing, unreadable or malformed, or if the
// SHA-256 of the weights differs from the description.
[[nodiscard]] Model read_model(const std::filesystem::path& description);

// The same with weights at another path than the description states.
[[nodiscard]] Model read_model(const std::filesystem::path& description,
                               const std::filesystem::path& onnx);

// The bytes of a file of a model. Throws Error(kModel) where read_file() throws Error(kInput).
[[nodiscard]] std::string read_model_file(const std::filesystem::path& path,
                                          std::size_t largest = kLargestFile);

[[nodiscard]] ModelDescription read_description(const std::filesystem::path& description);

// The network that ships with edvo, trained by its authors (models/README.md).
[[nodiscard]] Model own_model();

}  // namespace edvo
