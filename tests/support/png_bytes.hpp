// SPDX-License-Identifier: MIT
// What an encoder of libspng has written.
#pragma once

#include <spng.h>
#include <cstdlib>
#include <string>

namespace edvo::test {

// The PNG in an encoder's own buffer; frees the encoder.
[[nodiscard]] inline std::string take_png(spng_ctx* png) {
  std::size_t size = 0;
  int status = 0;
  void* const buffer = spng_get_png_buffer(png, &size, &status);
  const std::string bytes(static_cast<const char*>(buffer), size);
  std::free(buffer);
  spng_ctx_free(png);
  return bytes;
}

}  // namespace edvo::test
