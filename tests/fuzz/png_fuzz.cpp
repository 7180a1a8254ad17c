// SPDX-License-Identifier: MIT
// PNG whose checksums are right, so that the bytes of the rows are reached: filters, pixels of
// every kind, interlacing, too few rows. The fast reader of plain PNG and the general one see the
// same.
#include "edvo/core/error.hpp"
#include "edvo/io/image_file.hpp"
#include "fuzz/memory_file.hpp"

#include <libdeflate.h>

#include <array>
#include <optional>

using namespace edvo;

namespace {

struct Kind {
  char bits, colour_type;
};
constexpr std::array<Kind, 10> kKinds = {
    {{8, 0}, {8, 2}, {8, 6}, {16, 0}, {16, 2}, {16, 6}, {1, 0}, {4, 0}, {8, 3}, {8, 4}}};

std::string big_endian(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
          static_cast<char>(value >> 8), static_cast<char>(value)};
}

std::string chunk(const std::string& name, const std::string& bytes) {
  const std::string body = name + bytes;
  return big_endian(static_cast<std::uint32_t>(bytes.size())) + body +
         big_endian(libdeflate_crc32(0, body.data(), body.size()));
}

std::string zlib(std::string_view bytes) {
  static libdeflate_compressor* const compressor = libdeflate_alloc_compressor(1);
  std::string packed(libdeflate_zlib_compress_bound(compressor, bytes.size()), '\0');
  packed.resize(libdeflate_zlib_compress(compressor, bytes.data(), bytes.size(), packed.data(),
                                         packed.size()));
  return packed;
}

// Other chunks than header, pixels and end are what the fast reader leaves to the general one.
std::string png_of(std::string_view head, std::string_view rows, const std::string& more) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(head[i]); };
  const Kind kind = kKinds[byte(0) % kKinds.size()];
  const bool is_interlaced = byte(1) % 8 == 7;
  const std::string header = big_endian(1 + byte(2) % 40) + big_endian(1 + byte(3) % 40) +
                             std::string{kind.bits, kind.colour_type, 0, 0, is_interlaced};
  const std::string palette = kind.colour_type == 3 ? chunk("PLTE", std::string(96, 'p')) : "";
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + more + palette + chunk("IDAT", zlib(rows)) +
         chunk("IEND", "");
}

template <typename Read>
auto pixels(Read read, const std::string& png) -> std::optional<decltype(read(png))> {
  static fuzz::MemoryFile file;
  file.write(png);
  try {
    return read(file.path());
  } catch (const Error&) {
    return std::nullopt;
  }
}

template <typename Read>
void compare(Read read, const std::string& plain, const std::string& general) {
  const auto a = pixels(read, plain), b = pixels(read, general);
  fuzz::require(a.has_value() == b.has_value());
  if (!a) return;
  fuzz::require(a->size() == b->size() && a->isContinuous() && b->isContinuous());
  fuzz::require(std::equal(a->datastart, a->dataend, b->datastart));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 4;
  if (size < kHead) return 0;
  const std::string_view bytes = fuzz::text_of(data, size);
  const std::string plain = png_of(bytes.substr(0, kHead), bytes.substr(kHead), "");
  const std::string general =
      png_of(bytes.substr(0, kHead), bytes.substr(kHead), chunk("tEXt", std::string("a\0b", 3)));
  compare([](const std::string& path) { return read_colour(path); }, plain, general);
  compare([](const std::string& path) { return read_depth_raw(path); }, plain, general);
  return 0;
}
