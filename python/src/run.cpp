// SPDX-License-Identifier: MIT
// A whole sequence through the loop that the program runs too.
#include "edvo/run/run.hpp"

#include "edvo/report/recorder.hpp"
#include "edvo/report/run_folder.hpp"
#include "edvo/source/masked_source.hpp"
#include "interrupt.hpp"
#include "observers.hpp"
#include "python_text.hpp"
#include "run_map.hpp"
#include "source.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace edvo::python {
namespace {

namespace fs = std::filesystem;

struct RunChoice {
  std::string method;
  std::vector<std::string> changes;
  int threads = 2;
  std::optional<fs::path> output;  // folder for what the program writes
  bool force = false;
  std::vector<std::string> findings;  // for the report
  bool loops = true;
  std::optional<fs::path> map, save_map;
  bool update_map = false;
};

app::RunFlags map_flags(const RunChoice& choice) {
  app::RunFlags flags;
  flags.config.method = choice.method;
  if (choice.map) flags.map = choice.map->string();
  if (choice.save_map) flags.save_map = choice.save_map->string();
  flags.update_map = choice.update_map;
  flags.force = choice.force;
  flags.no_loops = !choice.loops;
  return flags;
}

struct MappedOutcome {
  RunOutcome run;
  std::optional<Error> failure;  // to find it in the map
  std::optional<std::vector<int>> map_segments;
};

// Without the GIL.
MappedOutcome run_recorded(RgbdSource& source, PythonObservers& watchers, const RunChoice& choice,
                           const Config& config, std::unique_ptr<EdgeDetector> detector) {
  const DistortedCamera camera = source.info().camera;
  RunDescription description =
      describe_run(source.info(), "edvo.run", choice.method, to_toml(config));
  std::vector<std::string> warnings = choice.findings;
  app::RunMaps maps(map_flags(choice), config, description,
                    [&](const std::string& text) { warnings.push_back(text); });
  Observers observers;
  std::optional<Recorder> recorder;
  if (choice.output) {
    make_named_run_folder(*choice.output, choice.force);
    description.warnings.insert(description.warnings.end(), warnings.begin(), warnings.end());
    recorder.emplace(*choice.output, description, true);
    observers.push_back(&*recorder);
  }
  observers.push_back(&watchers);
  const Interrupt interrupt;
  const auto run_with = [&](auto&& tracker) {
    return run(source, tracker, observers,
               {.threads = choice.threads, .should_stop = Interrupt::requested});
  };
  if (!choice.loops || !has_back_end(config))
    return {.run = run_with(Odometry(camera, config, std::move(detector)))};
  SlamInMap slam(camera, config, {.loops = {}, .links = {}, .keep_colour = maps.writes()},
                 std::move(detector), maps.origin(), maps.take_earlier(), choice.update_map);
  MappedOutcome outcome{.run = run_with(slam)};
  outcome.failure = maps.finish(slam, outcome.run.trajectory, choice.output);
  if (slam.localization()) outcome.map_segments = slam.localization()->segments;
  return outcome;
}

// As an edvo.Error with what an observer raised as its cause.
[[noreturn]] void raise_from(const Error& error, const nb::object& cause) {
  const nb::object type = nb::module_::import_("edvo.errors").attr("Error");
  const nb::object value = type(std::string(error.what()), static_cast<int>(error.code()));
  value.attr("__cause__") = cause;
  PyErr_SetObject(type.ptr(), value.ptr());
  throw nb::python_error();
}

nb::dict run_source(const nb::object& source, const nb::list& observers, const RunChoice& choice,
                    std::int64_t max_frames, const nb::object& own_detector,
                    const std::optional<MaskArray>& mask) {
  Shared cause;
  std::unique_ptr<RgbdSource> frames =
      make_source(source, {.max_frames = max_frames}, Interrupt::requested, &cause);
  if (mask) frames = std::make_unique<MaskedSource>(std::move(frames), to_mask(*mask), "the mask");
  PythonObservers watchers(observers);
  const Config config = config_of(choice.method, choice.changes);
  std::unique_ptr<EdgeDetector> detector = detector_of(config, frames->info().camera, own_detector);
  MappedOutcome outcome;
  try {
    const nb::gil_scoped_release release;
    outcome = run_recorded(*frames, watchers, choice, config, std::move(detector));
  } catch (const Error& error) {
    if (watchers.cause()) raise_from(error, watchers.cause());
    throw;
  }
  if (const auto untracked = failure_of(outcome.run, frames->info().origin); untracked) {
    outcome.run.error = untracked;
  } else if (outcome.failure) {
    outcome.run.error = outcome.failure;
  }
  nb::dict fields = watchers.outcome(outcome.run);
  fields["cause"] = nb::none();
  if (watchers.cause()) fields["cause"] = watchers.cause();
  if (cause) fields["cause"] = *cause;
  fields["map_segments"] = outcome.map_segments ? nb::cast(*outcome.map_segments) : nb::none();
  return fields;
}

}  // namespace

void add_run(nb::module_& module) {
  using namespace nb::literals;
  module.def(
      "run",
      [](const nb::object& source, const nb::list& observers, const std::string& method,
         const std::vector<std::string>& changes, int threads,
         const std::optional<fs::path>& output, bool force, std::int64_t max_frames,
         const std::vector<std::string>& findings, const nb::object& detector, bool loops,
         const std::optional<fs::path>& map, const std::optional<fs::path>& save_map,
         bool update_map, const std::optional<MaskArray>& mask) {
        return run_source(
            source, observers,
            {method, changes, threads, output, force, findings, loops, map, save_map, update_map},
            max_frames, detector, mask);
      },
      "source"_a, "observers"_a, "method"_a, "changes"_a, "threads"_a, "output"_a.none(), "force"_a,
      "max_frames"_a, "findings"_a, "detector"_a.none(), "loops"_a, "map"_a.none(),
      "save_map"_a.none(), "update_map"_a, "mask"_a.none());
  module.def(
      "read_mask",
      [](const fs::path& file, int width, int height) {
        return numpy_mask(read_mask(file, {width, height}));
      },
      "file"_a, "width"_a, "height"_a);
}

}  // namespace edvo::python
