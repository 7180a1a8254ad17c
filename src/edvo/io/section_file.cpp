// SPDX-License-Identifier: MIT
#include "edvo/io/section_file.hpp"

#include "edvo/core/clean_text.hpp"
#include "edvo/io/byte_codec.hpp"

#include <fmt/core.h>
#include <libdeflate.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>
#include <utility>

namespace edvo {
namespace {

constexpr std::string_view kEnd = "END ";
constexpr std::size_t kMagic = 8, kChecksum = 4;            // [bytes]
constexpr std::size_t kFileHead = kMagic + 4;               // [bytes], and its checksum
constexpr std::size_t kSectionHead = kSectionName + 8 + 8;  // [bytes], and its checksum
constexpr std::uint64_t kMostInflation = 1100;              // deflate has 1032 at most
// Residuals of images hardly shrink more at higher levels, which take longer.
constexpr int kLevel = 4;

std::uint32_t checksum(std::string_view bytes) {
  return libdeflate_crc32(0, bytes.data(), bytes.size());
}

bool has_checksum(std::string_view bytes_and_checksum) {
  const std::size_t size = bytes_and_checksum.size() - kChecksum;
  ByteReader end(bytes_and_checksum.substr(size));
  return checksum(bytes_and_checksum.substr(0, size)) == end.number<std::uint32_t>();
}

}  // namespace

struct SectionWriter::Compressor {
  struct Free {
    void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
  };
  std::unique_ptr<libdeflate_compressor, Free> deflater{libdeflate_alloc_compressor(kLevel)};
  std::string deflated;
};

SectionWriter::SectionWriter(const std::filesystem::path& path, const SectionFormat& format)
    : file_(path), compressor_(std::make_unique<Compressor>()) {
  if (!compressor_->deflater) throw std::bad_alloc();
  std::string head(format.magic);
  append_number(head, format.version);
  append_number(head, checksum(head));
  file_.append(head);
}

SectionWriter::~SectionWriter() = default;

void SectionWriter::add(std::string_view name, std::string_view content) {
  libdeflate_compressor* const deflater = compressor_->deflater.get();
  std::string& deflated = compressor_->deflated;
  deflated.resize(libdeflate_deflate_compress_bound(deflater, content.size()));
  const std::size_t size = libdeflate_deflate_compress(deflater, content.data(), content.size(),
                                                       deflated.data(), deflated.size());
  std::string head(name);
  append_number(head, std::uint64_t{content.size()});
  append_number(head, std::uint64_t{size});
  append_number(head, checksum(head));
  file_.append(head);
  const std::string_view stored = std::string_view(deflated).substr(0, size);
  file_.append(stored);
  std::string end;
  append_number(end, checksum(stored));
  file_.append(end);
}

void SectionWriter::finish() {
  add(kEnd, {});
  file_.commit();
}

struct SectionReader::Decompressor {
  struct Free {
    void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
  };
  std::unique_ptr<libdeflate_decompressor, Free> inflater{libdeflate_alloc_decompressor()};
};

SectionReader::SectionReader(const std::filesystem::path& path, const SectionFormat& format)
    : path_(path.string()), format_(format), decompressor_(std::make_unique<Decompressor>()) {
  if (!decompressor_->inflater) throw std::bad_alloc();
  const auto cannot = [this](const std::string& why) {
    return Error(ErrorCode::kInput, fmt::format("{}: {}", path_, why));
  };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw cannot("no such file");
  if (error) throw cannot(error.message());
  if (status.type() != std::filesystem::file_type::regular) throw cannot("not a regular file");
  left_ = std::filesystem::file_size(path, error);
  if (error) throw cannot(error.message());
  file_.open(path, std::ios::binary);
  if (!file_) throw cannot(fmt::format("cannot be opened, {}", std::strerror(errno)));

  if (left_ < kFileHead + kChecksum) throw damaged("", fmt::format("is no {}", format_.noun));
  const std::string head = take(kFileHead + kChecksum, "");
  if (!head.starts_with(format_.magic)) throw damaged("", fmt::format("is no {}", format_.noun));
  if (!has_checksum(head))
    throw damaged("", fmt::format("the head of this {} is damaged", format_.noun));
  ByteReader reader(std::string_view(head).substr(kMagic));
  const auto version = reader.number<std::uint32_t>();
  if (version > format_.version)
    throw damaged("", fmt::format("has version {}, this edvo reads up to {}; it was written by a "
                                  "newer edvo",
                                  version, format_.version));
}

SectionReader::~SectionReader() = default;

Error SectionReader::damaged(std::string_view section, std::string_view what) const {
  if (section.empty()) return {format_.damage, fmt::format("{}: {}", path_, what)};
  return {format_.damage, fmt::format("{}: section {} ({}) of this {} {}", path_, number_,
                                      clean_text(section), format_.noun, what)};
}

std::string SectionReader::take(std::uint64_t size, std::string_view section) {
  if (size > left_) throw damaged(section, "is cut off");
  std::string bytes(size, '\0');
  file_.read(bytes.data(), static_cast<std::streamsize>(size));
  if (file_.gcount() != static_cast<std::streamsize>(size))
    throw damaged(section, "cannot be read");
  left_ -= size;
  return bytes;
}

std::string SectionReader::inflate(const std::string& stored, std::uint64_t size,
                                   std::string_view section) {
  std::string content(size, '\0');
  std::size_t used = 0;
  if (libdeflate_deflate_decompress_ex(decompressor_->inflater.get(), stored.data(), stored.size(),
                                       content.data(), content.size(), &used,
                                       nullptr) != LIBDEFLATE_SUCCESS ||
      used != stored.size())
    throw damaged(section, "is damaged");
  return content;
}

Section SectionReader::next() {
  ++number_;
  const std::string head = take(kSectionHead + kChecksum, "head");
  if (!has_checksum(head)) throw damaged("head", "is damaged");
  Section section{.name = head.substr(0, kSectionName), .content = {}};
  ByteReader reader(std::string_view(head).substr(kSectionName));
  const auto size = reader.number<std::uint64_t>();
  stored_ = reader.number<std::uint64_t>();
  if (size > format_.largest || size > format_.largest_of_all - content_ ||
      size / kMostInflation > stored_)
    throw damaged(section.name, fmt::format("says that it has {} bytes", size));
  content_ += size;
  std::string stored = take(stored_, section.name);
  stored += take(kChecksum, section.name);
  if (!has_checksum(stored)) throw damaged(section.name, "is damaged");
  stored.resize(stored.size() - kChecksum);
  section.content = inflate(stored, size, section.name);
  if (section.name == kEnd && left_ > 0) throw damaged(section.name, "is followed by more");
  return section;
}

}  // namespace edvo
