// SPDX-License-Identifier: MIT
// ATE, RPE and drift.
#include "bindings.hpp"
#include "edvo/core/error.hpp"
#include "edvo/eval/evaluate.hpp"
#include "python_text.hpp"

#include <fmt/core.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <string>

namespace edvo::python {
namespace {

template <typename Enum>
Enum named(const char* what, const std::string& wanted) {
  std::string known;
  for (const auto& [value, name] : EnumNames<Enum>::names) {
    if (name == wanted) return value;
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  throw Error(ErrorCode::kUsage, fmt::format("{} {}: unknown, one of {}", what, wanted, known));
}

nb::dict statistics_dict(const Statistics& statistics) {
  nb::dict values;
  values["rmse"] = statistics.rmse;
  values["mean"] = statistics.mean;
  values["median"] = statistics.median;
  values["std"] = statistics.std;
  values["min"] = statistics.min;
  values["max"] = statistics.max;
  return values;
}

nb::object matched_indices(const std::vector<Match>& matches) {
  std::vector<std::int64_t> indices;
  for (const Match& match : matches)
    indices.insert(indices.end(), {static_cast<std::int64_t>(match.truth),
                                   static_cast<std::int64_t>(match.estimate)});
  return numpy_array(std::move(indices), {matches.size(), 2});
}

nb::object ate_errors(const Ate& ate) {
  std::vector<double> errors;
  for (const AteError& error : ate.errors) errors.push_back(error.distance);
  return numpy_array(std::move(errors), {ate.errors.size()});
}

// The fields of edvo.Evaluation.
nb::dict evaluation_dict(const Evaluation& evaluation) {
  const Similarity& alignment = evaluation.ate.truth_from_estimate;
  nb::dict values;
  values["protocol"] = describe_protocol(evaluation.options);
  values["matches"] = matched_indices(evaluation.matches);
  values["coverage"] = evaluation.coverage;
  values["ate"] = statistics_dict(evaluation.ate.distance);
  values["ate_errors"] = ate_errors(evaluation.ate);
  values["scale"] = alignment.scale;
  values["truth_from_estimate"] = numpy_pose(alignment.motion);
  values["rpe_pairs"] = evaluation.rpe ? evaluation.rpe->errors.size() : 0;
  values["rpe_translation"] =
      evaluation.rpe ? nb::object(statistics_dict(evaluation.rpe->translation)) : nb::none();
  values["rpe_rotation"] =
      evaluation.rpe ? nb::object(statistics_dict(evaluation.rpe->rotation)) : nb::none();
  values["drift_metres"] = evaluation.drift.distance;
  values["drift_percent"] =
      evaluation.drift.percent ? nb::cast(*evaluation.drift.percent) : nb::none();
  values["warnings"] = evaluation.warnings;
  return values;
}

}  // namespace

void add_evaluation(nb::module_& module) {
  using namespace nb::literals;
  module.def(
      "evaluate",
      [](const StampArray& truth_stamps, const PoseArray& truth_poses,
         const StampArray& truth_segments, const StampArray& estimate_stamps,
         const PoseArray& estimate_poses, const StampArray& estimate_segments,
         const std::string& alignment, const std::string& protocol, const std::string& delta,
         double max_difference, double offset, int max_pairs, std::uint64_t seed, int frames) {
        constexpr int kDecimals = 9;
        const EvalOptions options{
            .association = {.protocol = named<Protocol>("protocol", protocol),
                            .max_difference = max_difference,
                            .offset = offset},
            .alignment = named<AlignmentKind>("align", alignment),
            .rpe = {.delta = parse_delta(delta), .max_pairs = max_pairs, .seed = seed},
            .frames = frames};
        Evaluation evaluation;
        {
          const nb::gil_scoped_release release;
          evaluation =
              evaluate(to_trajectory(truth_stamps, kDecimals, truth_poses, truth_segments),
                       to_trajectory(estimate_stamps, kDecimals, estimate_poses, estimate_segments),
                       options);
        }
        return evaluation_dict(evaluation);
      },
      "truth_stamps"_a, "truth_poses"_a, "truth_segments"_a, "estimate_stamps"_a,
      "estimate_poses"_a, "estimate_segments"_a, "align"_a, "protocol"_a, "delta"_a,
      "max_difference"_a, "offset"_a, "max_pairs"_a, "seed"_a, "frames"_a);
}

}  // namespace edvo::python
