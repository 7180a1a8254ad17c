// SPDX-License-Identifier: MIT
#include "edvo/io/model_file.hpp"

#include "edvo/core/sha256.hpp"

#include <fmt/core.h>

#include <utility>

namespace edvo {

// Written by cmake/embed.cmake from models/.
extern const std::string_view kOwnNetworkDescription, kOwnNetworkWeights;

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestDescription = std::size_t{1} << 20;  // [bytes]

// The weights of the description that was read from `source`.
Model with_weights(ModelDescription described, const fs::path& source, const fs::path& onnx) {
  Model model{.description = std::move(described),
              .weights = read_model_file(onnx),
              .source = onnx.string()};
  const std::string& expected = model.description.sha256;
  if (expected.empty()) return model;
  if (const std::string found = sha256(model.weights); found != expected)
    throw Error(ErrorCode::kModel,
                fmt::format("{}: its SHA-256 is {}, but {} expects {}; the file is damaged or not "
                            "the one described",
                            model.source, found, source.string(), expected));
  return model;
}

}  // namespace

std::string read_model_file(const fs::path& path, std::size_t largest) {
  try {
    return read_file(path, largest);
  } catch (const Error& error) {
    throw Error(ErrorCode::kModel, error.what());
  }
}

ModelDescription read_description(const fs::path& description) {
  if (description.extension() == ".onnx")
    throw Error(ErrorCode::kModel,
                fmt::format("{}: a network is given by its description; write a TOML file beside "
                            "it with file = \"{}\" (docs/models.md)",
                            description.string(), description.filename().string()));
  return model_description_from_toml(read_model_file(description, kLargestDescription),
                                     description.string());
}

Model read_model(const fs::path& description) {
  ModelDescription described = read_description(description);
  const fs::path onnx = description.parent_path() / described.file;
  return with_weights(std::move(described), description, onnx);
}

Model read_model(const fs::path& description, const fs::path& onnx) {
  return with_weights(read_description(description), description, onnx);
}

Model own_model() {
  const std::string source = "edvo's own network";
  return {.description = model_description_from_toml(kOwnNetworkDescription, source),
          .weights = std::string(kOwnNetworkWeights),
          .source = source};
}

}  // namespace edvo
