// SPDX-License-Identifier: MIT
#include "edvo/io/text_list.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <optional>

namespace edvo {
namespace {

using std::filesystem::path;

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
constexpr std::string_view kSeparators = " \t,\r";

[[noreturn]] void fail(const path& file, int line, std::string_view reason) {
  throw Error(ErrorCode::kInput, fmt::format("{}:{}: {}", file.string(), line, reason));
}

std::vector<std::string> split_fields(const path& file, int number, std::string_view line) {
  std::vector<std::string> fields;
  for (std::size_t begin = line.find_first_not_of(kSeparators); begin != std::string_view::npos;
       begin = line.find_first_not_of(kSeparators, begin)) {
    const char quote = line[begin];
    const bool is_quoted = quote == '"' || quote == '\'';
    if (is_quoted) ++begin;
    std::size_t end = is_quoted ? line.find(quote, begin) : line.find_first_of(kSeparators, begin);
    if (is_quoted && end == std::string_view::npos) fail(file, number, "quote without its end");
    end = std::min(end, line.size());
    fields.emplace_back(line.substr(begin, end - begin));
    begin = is_quoted ? end + 1 : end;
  }
  return fields;
}

}  // namespace

std::vector<ListLine> read_list(const path& file, std::size_t fields_per_line) {
  const std::string bytes = read_file(file);
  std::string_view text = bytes;
  if (text.find('\0') != std::string_view::npos)
    throw Error(ErrorCode::kInput, fmt::format("{}: not a text file in ASCII or UTF-8 (has NUL "
                                               "bytes; UTF-16?)",
                                               file.string()));
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());

  std::vector<ListLine> lines;
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::size_t first = line.find_first_not_of(kSeparators);
    if (first == std::string_view::npos || line[first] == '#') continue;
    std::vector<std::string> fields = split_fields(file, number, line);
    if (fields.size() != fields_per_line)
      fail(file, number, fmt::format("expected {} fields, got {}", fields_per_line, fields.size()));
    lines.push_back({.number = number, .fields = std::move(fields)});
  }
  return lines;
}

Stamp stamp_field(const path& file, const ListLine& line, std::size_t field) {
  const std::optional<Stamp> stamp = parse_stamp(line.fields[field]);
  // Up to the year 2096, so that the difference of any two fits into 64 bits of nanoseconds.
  constexpr double kLatest = 4e9;  // [s]
  if (!stamp || std::abs(to_seconds(*stamp)) > kLatest)
    fail(file, line.number,
         fmt::format("time stamp {} is not a number of seconds up to {:g}",
                     printable(line.fields[field]), kLatest));
  return *stamp;
}

std::string printable(std::string_view text) {
  constexpr std::size_t kLongest = 80;
  std::string shown = "'";
  for (const char c : text.substr(0, kLongest))
    shown += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? '?' : c;
  return shown + (text.size() > kLongest ? "...'" : "'");
}

}  // namespace edvo
