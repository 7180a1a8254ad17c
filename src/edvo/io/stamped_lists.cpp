// SPDX-License-Identifier: MIT
// The layouts with time stamps: TUM's rgb.txt and depth.txt, and association files.
#include "edvo/core/associate.hpp"
#include "edvo/core/error.hpp"
#include "edvo/core/upper_median.hpp"
#include "edvo/io/dataset_layout.hpp"
#include "edvo/io/text_list.hpp"

#include <fmt/core.h>
#include <algorithm>
#include <cctype>
#include <utility>

namespace edvo {
namespace {

using std::filesystem::path;

constexpr std::size_t kMostCandidatesPerStamp = 200;  // a 5 kHz camera at a gap of 20 ms
constexpr double kMostEarly = 0.1;  // share of a list's lines that a disorder of sending explains

// A line of a list, whatever else it says.
template <typename Content>
struct Record {
  Stamp stamp;
  int line = 0;
  Content content;
};

// Orders records by stamp and keeps the first of equal stamps; says so in warnings.
template <typename Content>
void order_by_stamp(std::vector<Record<Content>>& records, const path& file,
                    std::vector<std::string>& warnings) {
  const auto by_stamp = [](const auto& a, const auto& b) { return a.stamp < b.stamp; };
  if (const auto late = std::ranges::is_sorted_until(records, by_stamp); late != records.end()) {
    std::size_t early = 0;
    for (std::size_t i = 1; i < records.size(); ++i)
      early += by_stamp(records[i], records[i - 1]) ? 1U : 0U;
    std::string warning = fmt::format("{}:{}: time stamp {} is earlier than the one before; sorted",
                                      file.string(), late->line, to_string(late->stamp));
    if (static_cast<double>(early) > kMostEarly * static_cast<double>(records.size()))
      warning += fmt::format(
          ". {} of {} lines are: the stamps are probably wrong. If the names of the images count "
          "up, "
          "take the lists out of the folder: images are then paired by name, at 30 Hz",
          early, records.size());
    warnings.push_back(std::move(warning));
    std::ranges::stable_sort(records, by_stamp);
  }
  const std::size_t count = records.size();
  int first_line = 0;
  const auto repeats = [&](const auto& a, const auto& b) {
    if (a.stamp != b.stamp) return false;
    if (first_line == 0) first_line = b.line;
    return true;
  };
  records.erase(std::unique(records.begin(), records.end(), repeats), records.end());
  if (records.size() < count)
    warnings.push_back(fmt::format("{}:{}: time stamp already seen; {} such lines left out",
                                   file.string(), first_line, count - records.size()));
}

std::vector<Record<path>> read_image_list(const path& file, std::vector<std::string>& warnings) {
  std::vector<Record<path>> images;
  for (const ListLine& line : read_list(file, 2))
    images.push_back({.stamp = stamp_field(file, line, 0),
                      .line = line.number,
                      .content = file.parent_path() / line.fields[1]});
  if (images.empty())
    throw Error(ErrorCode::kInput, fmt::format("{}: lists no image", file.string()));
  order_by_stamp(images, file, warnings);
  return images;
}

std::vector<Stamp> stamps_of(const std::vector<Record<path>>& images) {
  std::vector<Stamp> stamps;
  for (const auto& image : images) stamps.push_back(image.stamp);
  return stamps;
}

std::vector<double> in_seconds(const std::vector<Stamp>& stamps) {
  std::vector<double> seconds;
  for (const Stamp& stamp : stamps) seconds.push_back(script_seconds(stamp));
  return seconds;
}

[[noreturn]] void fail_without_pairs(const path& root, const std::vector<Stamp>& colour,
                                     const std::vector<Stamp>& depth, double largest_gap) {
  throw Error(ErrorCode::kInput,
              fmt::format("{}: no colour image has a depth image within {} s; the smallest gap is "
                          "{:.6f} s (colour from {} to {}, depth from {} to {})",
                          root.string(), largest_gap, smallest_gap(colour, depth),
                          to_string(colour.front()), to_string(colour.back()),
                          to_string(depth.front()), to_string(depth.back())));
}

// Rendered sequences are stamped 0, 1, 2, ... : frame numbers, which would be taken for seconds.
void note_frame_numbers(Listing& listing) {
  constexpr double kSlowest = 0.9;  // [s]
  const auto& frames = listing.frames;
  if (frames.size() < 3) return;
  std::vector<double> steps;
  for (std::size_t i = 1; i < frames.size(); ++i)
    steps.push_back(seconds_between(frames[i - 1].stamp, frames[i].stamp));
  const double usual = upper_median(steps);
  if (usual >= kSlowest)
    listing.notes.push_back(
        fmt::format("frames are {:g} s apart: if the stamps are frame numbers or milliseconds, "
                    "read \"s\" as such",
                    usual));
}

// Adds the pairs of the records that are closest in time.
void pair_by_time(Listing& listing, const std::vector<Record<path>>& colour,
                  const std::vector<Record<path>>& depth, const path& root, double largest_gap) {
  listing.colour_count = colour.size();
  listing.depth_count = depth.size();
  const std::vector<Stamp> colour_stamps = stamps_of(colour);
  const std::vector<Stamp> depth_stamps = stamps_of(depth);
  for (const auto [i, j] : associate(in_seconds(colour_stamps), in_seconds(depth_stamps),
                                     largest_gap, kMostCandidatesPerStamp))
    listing.frames.push_back({.stamp = colour[i].stamp,
                              .depth_stamp = depth[j].stamp,
                              .colour = colour[i].content,
                              .depth = depth[j].content});
  if (listing.frames.empty()) fail_without_pairs(root, colour_stamps, depth_stamps, largest_gap);
  listing.notes.push_back(fmt::format("{} pairs within {} s of {} colour and {} depth images",
                                      listing.frames.size(), largest_gap, colour.size(),
                                      depth.size()));
  note_frame_numbers(listing);
}

// Of an image's name without its ending: what a clock shows since the year 2001, as an integer in
// ns, us or ms, or as seconds with a fraction. Shorter numbers count frames.
std::optional<Stamp> stamp_in_name(const std::string& name) {
  constexpr std::size_t kSeconds = 10;  // digits
  const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
  if (name.empty() || name.front() == '0') return std::nullopt;
  if (digits < name.size())
    return digits == kSeconds && name[digits] == '.' ? parse_stamp(name) : std::nullopt;
  for (const std::size_t decimals : {3U, 6U, 9U})
    if (digits == kSeconds + decimals)
      return parse_stamp(name.substr(0, kSeconds) + '.' + name.substr(kSeconds));
  return std::nullopt;
}

// In their order; none if the name of any is no stamp.
std::optional<std::vector<Record<path>>> stamped_by_name(const std::vector<path>& files) {
  std::vector<Record<path>> records;
  for (const path& file : files) {
    const std::optional<Stamp> stamp = stamp_in_name(file.stem().string());
    if (!stamp) return std::nullopt;
    records.push_back({.stamp = *stamp, .line = 0, .content = file});
  }
  std::ranges::sort(records, {}, [](const Record<path>& record) { return record.stamp; });
  return records;
}

enum class Kind { kColour, kDepth, kUnknown };

Kind kind_of(std::string name) {
  std::ranges::transform(name, name.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.find("depth") != std::string::npos) return Kind::kDepth;
  for (const char* const word : {"rgb", "color", "colour", "image", ".jpg", ".jpeg"})
    if (name.find(word) != std::string::npos) return Kind::kColour;
  return Kind::kUnknown;
}

// Which half of an association file's lines names the depth image: 0 or 1.
std::size_t depth_half(const path& file, const std::vector<ListLine>& lines) {
  for (const ListLine& line : lines) {
    const Kind first = kind_of(line.fields[1]);
    const Kind second = kind_of(line.fields[3]);
    if (first == second) continue;
    if (first == Kind::kDepth || second == Kind::kColour) return 0;
    return 1;
  }
  throw Error(ErrorCode::kInput,
              fmt::format("{}: cannot tell which column is depth; neither path has \"depth\", "
                          "\"rgb\" or \"color\" in it",
                          file.string()));
}

}  // namespace

Listing read_tum_lists(const path& root, const DatasetOptions& options) {
  Listing listing;
  listing.layout = "TUM lists";
  const auto colour = read_image_list(root / "rgb.txt", listing.warnings);
  const auto depth = read_image_list(root / "depth.txt", listing.warnings);
  pair_by_time(listing, colour, depth, root, options.largest_gap);
  return listing;
}

std::optional<Listing> pair_stamped_files(const std::vector<path>& colour,
                                          const std::vector<path>& depth,
                                          const DatasetOptions& options) {
  constexpr double kMillimetres = 1000;  // [units/m]
  const auto colour_records = stamped_by_name(colour), depth_records = stamped_by_name(depth);
  if (!colour_records || !depth_records) return std::nullopt;
  Listing listing;
  listing.layout = "stamped images";
  listing.usual_depth_scale = kMillimetres;
  pair_by_time(listing, *colour_records, *depth_records, colour.front().parent_path().parent_path(),
               options.largest_gap);
  listing.notes.push_back("the names of the images are their time stamps");
  return listing;
}

Listing read_association_file(const path& file, const DatasetOptions& options) {
  Listing listing;
  listing.layout = fmt::format("association file {}", file.filename().string());
  const std::vector<ListLine> lines = read_list(file, 4);
  if (lines.empty())
    throw Error(ErrorCode::kInput, fmt::format("{}: lists no pair", file.string()));
  const std::size_t depth = 2 * depth_half(file, lines);
  const std::size_t colour = 2 - depth;

  std::vector<Record<FrameEntry>> pairs;
  for (const ListLine& line : lines) {
    const Stamp stamp = stamp_field(file, line, colour);
    pairs.push_back({.stamp = stamp,
                     .line = line.number,
                     .content = {.stamp = stamp,
                                 .depth_stamp = stamp_field(file, line, depth),
                                 .colour = file.parent_path() / line.fields[colour + 1],
                                 .depth = file.parent_path() / line.fields[depth + 1]}});
  }
  order_by_stamp(pairs, file, listing.warnings);

  std::size_t far_apart = 0;
  for (const auto& pair : pairs) {
    const FrameEntry& frame = pair.content;
    if (std::abs(seconds_between(frame.stamp, frame.depth_stamp)) >= options.largest_gap)
      ++far_apart;
    listing.frames.push_back(frame);
  }
  if (far_apart > 0)
    listing.warnings.push_back(fmt::format("{}: {} of {} pairs are {} s or more apart",
                                           file.string(), far_apart, pairs.size(),
                                           options.largest_gap));
  listing.colour_count = listing.depth_count = pairs.size();
  listing.notes.push_back(fmt::format("{} pairs as listed in {}, {} first", pairs.size(),
                                      file.filename().string(), depth == 0 ? "depth" : "colour"));
  note_frame_numbers(listing);
  return listing;
}

}  // namespace edvo
