// SPDX-License-Identifier: MIT
// A whole sequence through the loop that the program runs too.
#include "edvo/run/run.hpp"

#include "edvo/report/recorder.hpp"
#include "edvo/report/run_folder.hpp"
#include "edvo/slam/slam.hpp"
#include "interrupt.hpp"
#include "observers.hpp"
#include "source.hpp"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
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
};

// Without the GIL.
RunOutcome run_recorded(RgbdSource& source, PythonObservers& watchers, const RunChoice& choice,
                        const Config& config, std::unique_ptr<EdgeDetector> detector) {
  const DistortedCamera camera = source.info().camera;
  Observers observers;
  std::optional<Recorder> recorder;
  if (choice.output) {
    make_named_run_folder(*choice.output, choice.force);
    RunDescription description =
        describe_run(source.info(), "edvo.run", choice.method, to_toml(config));
    description.warnings.insert(description.warnings.end(), choice.findings.begin(),
                                choice.findings.end());
    recorder.emplace(*choice.output, description, true);
    observers.push_back(&*recorder);
  }
  observers.push_back(&watchers);
  const Interrupt interrupt;
  const auto run_with = [&](auto tracker) {
    return run(source, tracker, observers,
               {.threads = choice.threads, .should_stop = Interrupt::requested});
  };
  if (has_back_end(config)) return run_with(Slam(camera, config, {}, std::move(detector)));
  return run_with(Odometry(camera, config, std::move(detector)));
}

nb::dict run_source(const nb::object& source, const nb::list& observers, const RunChoice& choice,
                    std::int64_t max_frames, const nb::object& own_detector) {
  const std::unique_ptr<RgbdSource> frames = make_source(source, {.max_frames = max_frames});
  PythonObservers watchers(observers);
  const Config config = config_of(choice.method, choice.changes);
  std::unique_ptr<EdgeDetector> detector = detector_of(config, frames->info().camera, own_detector);
  RunOutcome outcome;
  {
    const nb::gil_scoped_release release;
    outcome = run_recorded(*frames, watchers, choice, config, std::move(detector));
  }
  return watchers.outcome(outcome);
}

}  // namespace

void add_run(nb::module_& module) {
  using namespace nb::literals;
  module.def(
      "run",
      [](const nb::object& source, const nb::list& observers, const std::string& method,
         const std::vector<std::string>& changes, int threads,
         const std::optional<fs::path>& output, bool force, std::int64_t max_frames,
         const std::vector<std::string>& findings, const nb::object& detector) {
        return run_source(source, observers, {method, changes, threads, output, force, findings},
                          max_frames, detector);
      },
      "source"_a, "observers"_a, "method"_a, "changes"_a, "threads"_a, "output"_a.none(), "force"_a,
      "max_frames"_a, "findings"_a, "detector"_a.none());
}

}  // namespace edvo::python
