// SPDX-License-Identifier: MIT
#include "sequence_flags.hpp"

#include "edvo/core/find_named.hpp"
#include "edvo/io/camera_file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "size_option.hpp"
#include "terminal.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <type_traits>

namespace edvo::app {
namespace {

// Options structs list themselves: each field becomes an option of the same name.
struct OptionAdder {
  CLI::App& verb;

  template <typename Field>
  void operator()(const std::string& name, Field& field, const Range& range,
                  const std::string& help) const {
    std::string option = "--" + name;
    std::replace(option.begin(), option.end(), '_', '-');
    if constexpr (std::is_enum_v<Field>) {
      std::string choices;
      for (const auto& [value, spelled] : EnumNames<Field>::names)
        choices += (choices.empty() ? "" : "|") + std::string(spelled);
      const auto choose = [&field, option, choices](const std::string& text) {
        const auto value = find_named<Field>(text);
        if (!value) throw CLI::ValidationError(option, text + ": expected one of " + choices);
        field = *value;
      };
      verb.add_option_function<std::string>(option, choose, help)
          ->type_name(choices)
          ->default_str(std::string(name_of(field)));
    } else if constexpr (std::is_same_v<Field, bool>) {
      verb.add_option(option, field, help)->type_name("on|off")->default_str(field ? "on" : "off");
    } else {
      const auto in_range = [range](const std::string& text) -> std::string {
        double value = 0;
        if (!CLI::detail::lexical_cast(text, value)) return "";  // reported as no number
        if (value >= range.lowest && value <= range.highest) return "";
        return fmt::format("{} is out of range, allowed: {} to {}", text, range.lowest,
                           range.highest);
      };
      verb.add_option(option, field, help)->check(in_range, "")->capture_default_str();
    }
  }
};

// The same field of view across the width on another number of pixels.
Camera scaled_to(const Camera& camera, const cv::Size& size) {
  const double scale = static_cast<double>(size.width) / camera.width;
  return {.fx = camera.fx * scale,
          .fy = camera.fy * scale,
          .cx = (camera.cx + 0.5) * scale - 0.5,
          .cy = (camera.cy - 0.5 * (camera.height - 1)) * scale + 0.5 * (size.height - 1),
          .width = size.width,
          .height = size.height};
}

DistortedCamera camera_from(const SequenceFlags& flags) {
  DistortedCamera camera = synth::kDefaultCamera;
  const Camera& standard = camera.pinhole;
  if (!flags.camera.empty()) {
    const cv::Size size = flags.size.empty() ? cv::Size(standard.width, standard.height)
                                             : parse_size("--size", flags.size);
    return read_camera(flags.camera, size);
  }
  if (!flags.size.empty()) camera.pinhole = scaled_to(standard, parse_size("--size", flags.size));
  return camera;
}

}  // namespace

void add_sequence_flags(CLI::App& verb, SequenceFlags& flags) {
  visit_fields(flags.options, OptionAdder{verb});
  verb.add_option(
      "--trajectory", flags.trajectory,
      "move as this TUM trajectory does, smoothed, turned, shifted and if need be shrunk to fit "
      "the scene; instead of --path");
  verb.add_option("--size", flags.size, "image size, WIDTHxHEIGHT (default 640x480)");
  verb.add_option("--camera", flags.camera,
                  "calibration file; lens distortion is rendered (default fx = fy = 525)");
  visit_fields(flags.options.sensor, OptionAdder{verb});
}

synth::SyntheticSequence make_sequence(const SequenceFlags& flags) {
  const DistortedCamera camera = camera_from(flags);
  if (flags.trajectory.empty()) return synth::make_sequence(flags.options, camera);
  const TrajectoryFile file = read_trajectory(flags.trajectory);
  for (const std::string& warning : file.warnings) say("warning: {}\n", warning);
  return synth::make_sequence(flags.options, camera, file.trajectory);
}

}  // namespace edvo::app
