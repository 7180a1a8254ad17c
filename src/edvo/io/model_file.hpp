// SPDX-License-Identifier: MIT
// An edge network as it lies on disk: its description and its weights.
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

// Throws Error(kModel) if one of the two files is missing, unreadable or not what it should be, or
// if the weights have another SHA-256 than described.
[[nodiscard]] Model read_model(const std::filesystem::path& description);

// The same with weights that lie elsewhere than the description says.
[[nodiscard]] Model read_model(const std::filesystem::path& description,
                               const std::filesystem::path& onnx);

// The bytes of a file that belongs to a model; what read_file() refuses is Error(kModel) here.
[[nodiscard]] std::string read_model_file(const std::filesystem::path& path,
                                          std::size_t largest = kLargestFile);

[[nodiscard]] ModelDescription read_description(const std::filesystem::path& description);

// The network that ships with edvo, trained by its authors (models/README.md).
[[nodiscard]] Model own_model();

}  // namespace edvo
