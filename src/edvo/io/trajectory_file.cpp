// SPDX-License-Identifier: MIT
#include "edvo/io/trajectory_file.hpp"

#include "edvo/core/error.hpp"
#include "edvo/io/file.hpp"
#include "edvo/io/output_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <optional>

namespace edvo {
namespace {

constexpr std::size_t kFields = 8;
constexpr double kShortestQuaternion = 1e-6;  // below, its direction is rounding noise
// Six written decimals leave at most about 1e-6; further off, it may not be a quaternion at all.
constexpr double kUnitTolerance = 0.01;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kFieldNames = "stamp tx ty tz qx qy qz qw";

struct Place {
  const std::string& source;
  std::size_t line = 0;  // counted from 1
};

[[noreturn]] void fail(const Place& place, const std::string& message) {
  throw Error(ErrorCode::kInput, fmt::format("{}:{}: {}", place.source, place.line, message));
}

// How often something happened, and where first.
struct Occurrences {
  std::size_t count = 0, first_line = 0;
};

void note(Occurrences& occurrences, std::size_t line) {
  if (occurrences.count++ == 0) occurrences.first_line = line;
}

bool is_separator(char c) {
  return c == ' ' || c == '\t' || c == ',' || c == '\r';
}

// The first kFields fields of a line, and how many there are.
struct Fields {
  std::array<std::string_view, kFields> text;
  std::size_t count = 0;
};

Fields split(std::string_view line) {
  Fields fields;
  for (std::size_t i = 0; i < line.size();) {
    if (is_separator(line[i])) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < line.size() && !is_separator(line[i])) ++i;
    if (fields.count < kFields) fields.text[fields.count] = line.substr(begin, i - begin);
    ++fields.count;
  }
  return fields;
}

// Foreign files may hold anything: no control characters and no novels in messages.
std::string quoted(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string shown = "\"";
  for (const char c : text.substr(0, kLongest))
    shown += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return shown + (text.size() > kLongest ? "...\"" : "\"");
}

double number(std::string_view text, const Place& place) {
  std::string_view digits = text;
  if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
  double value = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (status != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value))
    fail(place,
         fmt::format("expected a finite number, got {}; leave lost poses out", quoted(text)));
  return value;
}

// How a line is to be read.
struct Layout {
  bool in_nanoseconds = false;     // the stamps, as integers; more fields may follow the pose
  bool w_first = false;            // qw qx qy qz
  bool names_nanoseconds = false;  // a comment or header has "timestamp [ns]"
  std::size_t header = 0;          // line that names the columns without being a comment, 0 = none
};

// Whether a line that names the columns has qw before qx, also as q_RS_w []; none if it does not
// name them.
std::optional<bool> named_w_first(std::string_view line) {
  const auto place_of = [&](std::initializer_list<std::string_view> names) {
    std::size_t place = std::string_view::npos;
    for (const std::string_view name : names) place = std::min(place, line.find(name));
    return place;
  };
  const std::size_t x = place_of({"qx", "q_x", "q_RS_x"});
  const std::size_t w = place_of({"qw", "q_w", "q_RS_w"});
  if (x == std::string_view::npos || w == std::string_view::npos) return std::nullopt;
  return w < x;
}

bool is_integer(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

bool is_in_nanoseconds(std::string_view stamp) {
  constexpr std::size_t kFewestDigits = 16;  // seconds have at most 10
  return stamp.size() >= kFewestDigits && is_integer(stamp);
}

// EuRoC's csv has nanoseconds, commas and qw first, with velocities and biases after the pose. Of
// stamps near 0 only the header tells that.
bool is_euroc(std::string_view line, const Fields& fields, const Layout& layout) {
  if (fields.count < kFields || line.find(',') == std::string_view::npos) return false;
  return is_in_nanoseconds(fields.text[0]) ||
         (layout.names_nanoseconds && is_integer(fields.text[0]));
}

// By the comments and the header before the first pose, and that pose.
Layout layout_of(std::string_view text) {
  Layout layout;
  std::optional<bool> w_first;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const Fields fields = split(line);
    if (fields.count == 0) continue;
    const std::optional<bool> named = named_w_first(line);
    if (named) w_first = named;
    if (line.find("[ns]") != std::string_view::npos) layout.names_nanoseconds = true;
    if (fields.text[0].front() == '#') continue;
    if (named && layout.header == 0) {
      layout.header = number;
      continue;
    }
    layout.in_nanoseconds = is_euroc(line, fields, layout);
    break;
  }
  layout.w_first = w_first.value_or(layout.in_nanoseconds);
  return layout;
}

std::optional<Stamp> parse_nanoseconds(std::string_view text) {
  constexpr int kDecimals = 9;
  std::int64_t value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return Stamp{value, kDecimals};
}

[[noreturn]] void fail_fields(const Fields& fields, const Place& place) {
  constexpr std::size_t kMatrix = 12;
  const std::string_view hint =
      fields.count == kMatrix
          ? "; 12 are a matrix as KITTI writes it, which has no stamp: write its poses with the "
            "stamps of times.txt"
          : "";
  fail(place,
       fmt::format("expected {} fields ({}), got {}{}", kFields, kFieldNames, fields.count, hint));
}

// Of a stamp too large for seconds since 1970, by its order of magnitude.
std::string_view hint_of_unit(std::string_view text) {
  const std::size_t digits = is_integer(text.substr(0, text.find('.'))) ? text.find('.') : 0;
  const std::size_t count = std::min(digits, text.size());
  if (count >= 18) return "; divide nanoseconds by 1e9";
  if (count >= 15) return "; divide microseconds by 1e6, or nanoseconds by 1e9";
  if (count >= 12) return "; divide milliseconds by 1000";
  return "";
}

Stamp parse_stamp_field(std::string_view text, const Layout& layout, const Place& place) {
  // Up to the year 2096, so that the difference of any two fits into 64 bits of nanoseconds.
  constexpr double kLatest = 4e9;  // [s]
  const std::optional<Stamp> stamp =
      layout.in_nanoseconds ? parse_nanoseconds(text) : parse_stamp(text);
  if (!stamp || std::abs(to_seconds(*stamp)) > kLatest)
    fail(place, fmt::format("expected a stamp in {} up to {:g} s, got {}{}",
                            layout.in_nanoseconds ? "nanoseconds" : "seconds", kLatest,
                            quoted(text), layout.in_nanoseconds ? "" : hint_of_unit(text)));
  return *stamp;
}

struct Line {
  StampedPose pose;
  std::size_t number = 0;
  double quaternion_length = 1;
};

Line parse_pose(const Fields& fields, const Layout& layout, const Place& place) {
  if (layout.in_nanoseconds ? fields.count < kFields : fields.count != kFields)
    fail_fields(fields, place);
  const Stamp stamp = parse_stamp_field(fields.text[0], layout, place);
  std::array<double, kFields> v{};
  for (std::size_t i = 1; i < kFields; ++i) v[i] = number(fields.text[i], place);
  const Eigen::Quaterniond rotation = layout.w_first ? Eigen::Quaterniond(v[4], v[5], v[6], v[7])
                                                     : Eigen::Quaterniond(v[7], v[4], v[5], v[6]);
  const double length = rotation.norm();
  if (!(length > kShortestQuaternion) || !std::isfinite(length))
    fail(place,
         fmt::format("a quaternion of length {:.3g} is no rotation; leave lost poses out", length));
  return {.pose = {.stamp = stamp,
                   .world_from_camera = {.rotation = rotation.normalized(),
                                         .translation = {v[1], v[2], v[3]}}},
          .number = place.line,
          .quaternion_length = length};
}

// Of a line that segment_line() wrote.
std::optional<int> segment_of(const Fields& fields) {
  if (fields.count != 3 || fields.text[0] != "#" || fields.text[1] != "segment")
    return std::nullopt;
  const std::string_view text = fields.text[2];
  int segment = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), segment);
  if (status != std::errc{} || end != text.data() + text.size() || segment < 0) return std::nullopt;
  return segment;
}

std::vector<Line> parse_lines(std::string_view text, const Layout& layout,
                              const std::string& source) {
  std::vector<Line> lines;
  int segment = 0;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const Fields fields = split(text.substr(0, end));
    segment = segment_of(fields).value_or(segment);
    if (fields.count > 0 && fields.text[0].front() != '#' && number != layout.header) {
      lines.push_back(parse_pose(fields, layout, {source, number}));
      lines.back().pose.segment = segment;
    }
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

void warn(std::vector<std::string>& warnings, const std::string& source,
          const Occurrences& occurrences, std::string_view what) {
  if (occurrences.count == 0) return;
  std::string more;
  if (occurrences.count > 1) more = fmt::format(" ({} such lines)", occurrences.count);
  warnings.push_back(fmt::format("{}:{}: {}{}", source, occurrences.first_line, what, more));
}

}  // namespace

TrajectoryFile parse_trajectory(std::string_view text, const std::string& source) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const Layout layout = layout_of(text);
  std::vector<Line> lines = parse_lines(text, layout, source);
  if (lines.empty())
    throw Error(ErrorCode::kInput,
                fmt::format("{}: no pose in it; expected lines of \"{}\"", source, kFieldNames));
  Occurrences unordered, repeated, not_unit;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i > 0 && lines[i].pose.stamp < lines[i - 1].pose.stamp) note(unordered, lines[i].number);
    if (std::abs(lines[i].quaternion_length - 1.0) > kUnitTolerance)
      note(not_unit, lines[i].number);
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return a.pose.stamp < b.pose.stamp; });
  TrajectoryFile file;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i + 1 < lines.size() && lines[i].pose.stamp == lines[i + 1].pose.stamp) {
      note(repeated, lines[i + 1].number);
    } else {
      file.trajectory.push_back(lines[i].pose);
    }
  }
  if (layout.in_nanoseconds)
    file.warnings.push_back(fmt::format("{}: read as EuRoC's csv: nanoseconds, {} first", source,
                                        layout.w_first ? "qw" : "qx"));
  else if (layout.w_first)
    file.warnings.push_back(
        fmt::format("{}: read with qw first, as it says of its columns", source));
  warn(file.warnings, source, unordered, "stamp before the previous one; poses were sorted");
  warn(file.warnings, source, repeated, "stamp seen before; its last pose was kept");
  warn(file.warnings, source, not_unit, "quaternion not of unit length; it was normalized");
  return file;
}

TrajectoryFile read_trajectory(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  if (text.starts_with("\x89MCAP"))
    throw Error(ErrorCode::kInput,
                fmt::format("{}: MCAP is not read as a trajectory, only written; give a run's "
                            "folder, or a file in the format of TUM or EuRoC",
                            file.string()));
  return parse_trajectory(text, file.string());
}

std::string segment_line(int segment) {
  return fmt::format("# segment {}", segment);
}

std::string trajectory_line(const StampedPose& pose) {
  const Eigen::Vector3d& t = pose.world_from_camera.translation;
  const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
  if (!is_finite(pose.world_from_camera))
    throw Error(ErrorCode::kInternal,
                fmt::format("pose at {} is not finite", to_string(pose.stamp)));
  return fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}", to_string(pose.stamp),
                     t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

void write_trajectory(const std::filesystem::path& file, const Trajectory& trajectory) {
  std::string text;
  int segment = 0;
  for (const StampedPose& pose : trajectory) {
    if (pose.segment != segment) text += segment_line(pose.segment) + '\n';
    segment = pose.segment;
    text += trajectory_line(pose) + '\n';
  }
  write_whole(file, text);
}

}  // namespace edvo
