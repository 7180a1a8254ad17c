// SPDX-License-Identifier: MIT
// The layouts without time stamps in names: images matched by name or number.
#include "edvo/core/error.hpp"
#include "edvo/io/dataset_layout.hpp"
#include "edvo/io/text_list.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <map>
#include <string_view>

namespace edvo {
namespace {

using std::filesystem::path;

constexpr std::string_view kDigits = "0123456789";

// Orders "2" before "10" and "007" with "7": digits by length and value.
struct NumberLess {
  bool operator()(std::string_view a, std::string_view b) const {
    a.remove_prefix(std::min(a.find_first_not_of('0'), a.size()));
    b.remove_prefix(std::min(b.find_first_not_of('0'), b.size()));
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  }
};

// Orders text with the numbers in it as people do: frame2 before frame10.
struct NaturalLess {
  bool operator()(std::string_view a, std::string_view b) const {
    const std::string_view whole_a = a, whole_b = b;
    while (!a.empty() && !b.empty()) {
      const std::string_view number_a = a.substr(0, a.find_first_not_of(kDigits));
      const std::string_view number_b = b.substr(0, b.find_first_not_of(kDigits));
      if (number_a.empty() || number_b.empty()) {
        if (a.front() != b.front()) return a.front() < b.front();
        a.remove_prefix(1);
        b.remove_prefix(1);
      } else {
        if (NumberLess{}(number_a, number_b)) return true;
        if (NumberLess{}(number_b, number_a)) return false;
        a.remove_prefix(number_a.size());
        b.remove_prefix(number_b.size());
      }
    }
    if (a.empty() != b.empty()) return a.empty();
    return whole_a < whole_b;
  }
};

// The last number in a file's stem, as written; empty if there is none or it is a fraction, as in
// the name 1305031102.175304.png: such stamps differ between colour and depth.
std::string last_number(const std::string& stem) {
  const std::size_t end = stem.find_last_of(kDigits);
  if (end == std::string::npos) return {};
  const std::size_t before = stem.find_last_not_of(kDigits, end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  const bool is_fraction = begin >= 2 && stem[begin - 1] == '.' &&
                           kDigits.find(stem[begin - 2]) != std::string_view::npos;
  return is_fraction ? std::string() : stem.substr(begin, end + 1 - begin);
}

template <typename Less>
using Keyed = std::map<std::string, path, Less>;

using Pairs = std::vector<std::pair<path, path>>;

template <typename Less>
Pairs matches(const Keyed<Less>& colour, const Keyed<Less>& depth) {
  Pairs pairs;
  for (const auto& [key, file] : colour)
    if (const auto same = depth.find(key); same != depth.end())
      pairs.emplace_back(file, same->second);
  return pairs;
}

Keyed<NaturalLess> by_stem(const std::vector<path>& files) {
  Keyed<NaturalLess> keyed;
  for (const path& file : files) keyed.emplace(file.stem().string(), file);
  return keyed;
}

// Empty if a number occurs twice: then it does not tell the files apart.
Keyed<NumberLess> by_number(const std::vector<path>& files) {
  Keyed<NumberLess> keyed;
  for (const path& file : files) {
    const std::string number = last_number(file.stem().string());
    if (number.empty() || !keyed.emplace(number, file).second) return {};
  }
  return keyed;
}

// "index seconds" in each line of a file beside the folders.
using StampOf = std::map<std::string, Stamp, NumberLess>;

StampOf read_stamps(const path& file) {
  StampOf stamps;
  for (const ListLine& line : read_list(file, 2))
    if (!stamps.emplace(line.fields[0], stamp_field(file, line, 1)).second)
      throw Error(ErrorCode::kInput, fmt::format("{}:{}: index {} was already there", file.string(),
                                                 line.number, line.fields[0]));
  return stamps;
}

// Of each pair, in their order, by the number in the name of its colour image.
std::vector<Stamp> stamps_in(const path& file, const Pairs& pairs) {
  const StampOf known = read_stamps(file);
  std::vector<Stamp> stamps;
  for (const auto& [colour, depth] : pairs) {
    const auto stamp = known.find(last_number(colour.stem().string()));
    if (stamp == known.end())
      throw Error(ErrorCode::kInput,
                  fmt::format("{}: no line for {}", file.string(), colour.filename().string()));
    if (!stamps.empty() && !(stamps.back() < stamp->second))
      throw Error(ErrorCode::kInput, fmt::format("{}: the stamps do not increase at {}",
                                                 file.string(), colour.filename().string()));
    stamps.push_back(stamp->second);
  }
  return stamps;
}

// What a recorder wrote beside the folders, if it fits the images; says what became of it.
std::vector<Stamp> written_stamps(const path& root, const Pairs& pairs, Listing& listing) {
  const path file = root / "timestamps.txt";
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return {};
  try {
    std::vector<Stamp> stamps = stamps_in(file, pairs);
    listing.notes.push_back(
        fmt::format("{} pairs matched by name; time stamps from {}", pairs.size(), file.string()));
    return stamps;
  } catch (const Error& error) {
    listing.warnings.push_back(fmt::format(
        "time stamps are not taken from timestamps.txt, which needs a line \"index seconds\" for "
        "each image: {}",
        error.what()));
    return {};
  }
}

std::vector<Stamp> assumed_stamps(std::size_t count, double rate, Listing& listing) {
  constexpr int kDecimals = 6;
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < count; ++i)
    stamps.push_back(stamp_from_seconds(static_cast<double>(i) / rate, kDecimals));
  listing.notes.push_back(
      fmt::format("{} pairs matched by name; no time stamps, so {} frames per second are assumed",
                  count, rate));
  return stamps;
}

}  // namespace

Listing pair_numbered_files(const std::vector<path>& colour, const std::vector<path>& depth,
                            const DatasetOptions& options) {
  constexpr double kMillimetres = 1000;  // [units/m]
  Listing listing;
  listing.layout = "numbered images";
  listing.colour_count = colour.size();
  listing.depth_count = depth.size();
  listing.usual_depth_scale = kMillimetres;
  Pairs pairs = matches(by_stem(colour), by_stem(depth));
  if (pairs.empty()) pairs = matches(by_number(colour), by_number(depth));
  if (pairs.empty())
    throw Error(ErrorCode::kInput,
                fmt::format("{}: {} colour and {} depth images, but no two with the same name or "
                            "number (for example {} and {}); with time stamps as names, rgb.txt "
                            "and depth.txt are needed",
                            colour.front().parent_path().string(), colour.size(), depth.size(),
                            colour.front().filename().string(), depth.front().filename().string()));

  const path root = colour.front().parent_path().parent_path();
  std::vector<Stamp> stamps = written_stamps(root, pairs, listing);
  if (stamps.empty()) stamps = assumed_stamps(pairs.size(), options.assumed_rate, listing);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    listing.frames.push_back({.stamp = stamps[i],
                              .depth_stamp = stamps[i],
                              .colour = std::move(pairs[i].first),
                              .depth = std::move(pairs[i].second)});
  if (pairs.size() < std::max(colour.size(), depth.size()))
    listing.warnings.push_back(fmt::format(
        "{}: {} colour and {} depth images make only {} pairs of the same name",
        colour.front().parent_path().string(), colour.size(), depth.size(), pairs.size()));
  return listing;
}

}  // namespace edvo
