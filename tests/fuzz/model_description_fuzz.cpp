// SPDX-License-Identifier: MIT
// Descriptions of models; what is read is written and read the same.
#include "edvo/core/error.hpp"
#include "edvo/io/model_description.hpp"
#include "fuzz/memory_file.hpp"

using namespace edvo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const ModelDescription model = model_description_from_toml(fuzz::text_of(data, size), "fuzz");
    const std::string text = to_toml(model);
    fuzz::require(to_toml(model_description_from_toml(text, "again")) == text);
  } catch (const Error& error) {
    fuzz::require(!std::string_view(error.what()).starts_with("again"));
  }
  return 0;
}
