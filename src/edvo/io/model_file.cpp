// SPDX-License-Identifier: MIT
#include "edvo/io/model_file.hpp"

#include "edvo/core/sha256.hpp"
#include "edvo/io/file.hpp"

#include <fmt/core.h>

namespace edvo {

// Written by cmake/embed.cmake from models/.
extern const std::string_view kOwnNetworkDescription, kOwnNetworkWeights;

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestDescription = std::size_t{1} << 20;  // [bytes]

std::string read_model_file(const fs::path& path, std::size_t largest) {
  try {
    return read_file(path, largest);
  } catch (const Error& error) {
    throw Error(ErrorCode::kModel, error.what());
  }
}

}  // namespace

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
  return read_model(description, description.parent_path() / read_description(description).file);
}

Model read_model(const fs::path& description, const fs::path& onnx) {
  Model model{.description = read_description(description),
              .weights = read_model_file(onnx, kLargestFile),
              .source = onnx.string()};
  const std::string& expected = model.description.sha256;
  if (expected.empty()) return model;
  if (const std::string found = sha256(model.weights); found != expected)
    throw Error(ErrorCode::kModel,
                fmt::format("{}: its SHA-256 is {}, but {} expects {}; the file is damaged or not "
                            "the one described",
                            model.source, found, description.string(), expected));
  return model;
}

Model own_model() {
  const std::string source = "edvo's own network";
  return {.description = model_description_from_toml(kOwnNetworkDescription, source),
          .weights = std::string(kOwnNetworkWeights),
          .source = source};
}

}  // namespace edvo
