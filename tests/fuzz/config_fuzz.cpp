// SPDX-License-Identifier: MIT
// Configurations and single settings; what is read is written and read the same.
#include "edvo/core/error.hpp"
#include "edvo/odometry/config.hpp"
#include "fuzz/memory_file.hpp"

using namespace edvo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::text_of(data, size);
  try {
    const std::string written = to_toml(config_from_toml(text, "fuzz", Config{}));
    fuzz::require(to_toml(config_from_toml(written, "again", Config{})) == written);
  } catch (const Error& error) {
    fuzz::require(!std::string_view(error.what()).starts_with("again"));
  }
  try {
    Config config;
    set_option(config, text);
  } catch (const Error&) {
  }
  return 0;
}
