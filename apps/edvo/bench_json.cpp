// SPDX-License-Identifier: MIT
#include "bench_tables.hpp"

#include <nlohmann/json.hpp>

namespace edvo::app {
namespace {

using Json = nlohmann::ordered_json;

Json or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json json_of(const RunFigures& run) {
  return {{"tracked", run.tracked},         {"lost", run.lost},
          {"restarted", run.restarted},     {"skipped", run.skipped},
          {"lost_events", run.lost_events}, {"segments", run.segments},
          {"keyframes", run.keyframes},     {"ms_median", run.median_milliseconds},
          {"ms_p95", run.p95_milliseconds}};
}

Json json_of(const Evaluation& evaluation, const std::optional<double>& live_ate) {
  Json json = {{"ate_rmse_m", evaluation.ate.distance.rmse},
               {"live_ate_rmse_m", or_null(live_ate)},
               {"rpe_translation_rmse_m_per_s", nullptr},
               {"rpe_rotation_rmse_deg_per_s", nullptr},
               {"pairs", evaluation.matches.size()},
               {"coverage", evaluation.coverage},
               {"drift_percent", or_null(evaluation.drift.percent)}};
  if (evaluation.rpe) {
    json["rpe_translation_rmse_m_per_s"] = evaluation.rpe->translation.rmse;
    json["rpe_rotation_rmse_deg_per_s"] = evaluation.rpe->rotation.rmse;
  }
  return json;
}

Json json_of(const BenchCell& cell) {
  Json json = {{"name", cell.name}, {"kind", name_of(cell.kind)}, {"state", name_of(cell.state)}};
  if (cell.kind != CellKind::kPeer) {
    json["method"] = cell.method;
    json["set"] = cell.set;
    json["config_hash"] = cell.config_hash;
    json["reused_runs"] = cell.reused;
    json["identical"] = cell.identical;
    json["run"] = cell.run ? json_of(*cell.run) : Json(nullptr);
  }
  json["files"] = Json::array();
  for (const std::filesystem::path& file : cell.files) json["files"].push_back(file.string());
  json["errors"] = cell.evaluation ? json_of(*cell.evaluation, cell.live_ate) : Json(nullptr);
  json["problem"] = cell.problem.empty() ? Json(nullptr) : Json(cell.problem);
  return json;
}

Json paper_of(const std::optional<PublishedTables>& published, const std::string& sequence) {
  const PublishedRow* const row = published ? find_row(*published, sequence) : nullptr;
  if (!row) return nullptr;
  Json json;
  for (std::size_t i = 0; i < row->systems.size(); ++i) {
    const PublishedFigures& figures = row->systems[i];
    json[published->columns[i]] = {
        {"ate_rmse_m", or_null(figures.ate)},
        {"rpe_translation_rmse_m_per_s", or_null(figures.rpe_translation)},
        {"rpe_rotation_rmse_deg_per_s", or_null(figures.rpe_rotation)}};
  }
  return json;
}

}  // namespace

std::string bench_json(const BenchManifest& manifest, const BenchResult& result) {
  Json json = {{"schema", 1},
               {"manifest", manifest.file.string()},
               {"output", manifest.output.string()},
               {"protocol", describe_protocol({})},
               {"repeats", manifest.repeats},
               {"interrupted", result.interrupted},
               {"sequences", Json::array()}};
  for (const BenchRow& row : result.rows) {
    Json sequence = {{"name", row.sequence},
                     {"frames", row.frames},
                     {"ground_truth", row.ground_truth},
                     {"paper", paper_of(manifest.published, row.sequence)},
                     {"systems", Json::array()}};
    for (const BenchCell& cell : row.cells) sequence["systems"].push_back(json_of(cell));
    json["sequences"].push_back(sequence);
  }
  // File names may hold anything, JSON only UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace edvo::app
