// SPDX-License-Identifier: MIT
#include "bench_manifest.hpp"

#include "config_flags.hpp"
#include "edvo/core/did_you_mean.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "edvo/report/run_folder.hpp"
#include "enum_option.hpp"
#include "toml_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

// The manifest as it is read: where it is, where its paths start, and what has been noticed.
struct Reader : TomlFile {
  fs::path base, data;  // of relative paths: its own and the data's
  bool with_peers = true;
  std::vector<std::string> warnings;
  std::function<fs::path(const std::string&)> pull;
};

// --- values -------------------------------------------------------------------------------------

std::optional<std::int64_t> find_count(const Reader& reader, const toml::table& table,
                                       std::string_view key, std::int64_t most) {
  const toml::node* const node = table.get(key);
  if (!node) return std::nullopt;
  const auto* const count = node->as_integer();
  if (!count || count->get() < 1 || count->get() > most)
    refuse(reader, *node, fmt::format("{}: expected a whole number from 1 to {}", key, most));
  return count->get();
}

std::optional<double> find_positive(const Reader& reader, const toml::table& table,
                                    std::string_view key) {
  const toml::node* const node = table.get(key);
  if (!node) return std::nullopt;
  const std::optional<double> number = node->is_number() ? node->value<double>() : std::nullopt;
  if (!number || !(*number > 0) || !std::isfinite(*number))
    refuse(reader, *node, fmt::format("{}: expected a number above 0", key));
  return number;
}

// Something that must be there. Links stay as they are: folders tell by their names.
std::optional<fs::path> find_path(const Reader& reader, const toml::table& table,
                                  std::string_view key) {
  const std::optional<std::string> value = find_text(reader, table, key);
  if (!value) return std::nullopt;
  fs::path path = (reader.data / *value).lexically_normal();
  std::error_code error;
  if (!fs::exists(path, error))
    refuse(reader, *table.get(key),
           fmt::format("{}: {} is not there; relative paths start at {}, or where --data says", key,
                       path.string(), reader.data.string()));
  return path;
}

// --- systems ------------------------------------------------------------------------------------

// Two names that make the same folder are the same.
using TakenFolders = std::set<std::string>;

void take_name(const Reader& reader, const toml::node& node, const std::string& name,
               TakenFolders& taken) {
  if (!taken.insert(folder_name(name)).second)
    refuse(reader, node,
           fmt::format("'{}' is there twice, at least as the name of a folder, {}", name,
                       folder_name(name)));
}

void check_method(const Reader& reader, const toml::node& node, const std::string& method) {
  const std::vector<std::string> known = names_of<Method>();
  if (!find_named<Method>(method))
    refuse(reader, node,
           fmt::format("unknown method '{}'{} (known: {})", method, did_you_mean(method, known),
                       fmt::join(known, ", ")));
}

BenchSystem read_variant(const Reader& reader, const toml::table& table) {
  check_keys(reader, table, {"name", "method", "set"});
  BenchSystem variant{
      .name = text(reader, table, "name"),
      .method = find_text(reader, table, "method").value_or(std::string(name_of(kDefaultMethod))),
      .set = texts(reader, table, "set"),
      .config = {}};
  if (table.contains("method")) check_method(reader, *table.get("method"), variant.method);
  if (variant.set.empty())
    refuse(reader, table,
           fmt::format("variant '{}': 'set' is missing, what differs from {}: set = "
                       "[\"group.field=value\"]",
                       variant.name, variant.method));
  try {
    variant.config = resolve_config({.method = variant.method, .file = {}, .set = variant.set});
  } catch (const Error& error) {
    refuse(reader, *table.get("set"), error.what());
  }
  return variant;
}

std::vector<BenchSystem> read_systems(const Reader& reader, const toml::table& root) {
  std::vector<BenchSystem> systems;
  TakenFolders taken;
  for (const std::string& method : texts(reader, root, "methods")) {
    const toml::node& node = *root.get("methods");
    check_method(reader, node, method);
    take_name(reader, node, method, taken);
    systems.push_back({.name = method,
                       .method = method,
                       .set = {},
                       .config = resolve_config({.method = method, .file = {}, .set = {}})});
  }
  for (const toml::table* table : tables(reader, root, "variant", "variant")) {
    systems.push_back(read_variant(reader, *table));
    take_name(reader, *table, systems.back().name, taken);
  }
  if (systems.empty())
    refuse(reader, root, "nothing to run: methods = [\"canny+corner\"] names what to compare");
  return systems;
}

// --- sequences ----------------------------------------------------------------------------------

Trajectory read_poses(Reader& reader, const fs::path& file) {
  TrajectoryFile read = read_trajectory(file);
  reader.warnings.insert(reader.warnings.end(), read.warnings.begin(), read.warnings.end());
  return std::move(read.trajectory);
}

std::vector<BenchPeer> read_peers(Reader& reader, const toml::table& sequence,
                                  const std::vector<BenchSystem>& systems) {
  std::vector<BenchPeer> peers;
  TakenFolders taken;
  for (const BenchSystem& system : systems) taken.insert(folder_name(system.name));
  for (const toml::table* table : tables(reader, sequence, "peer", "sequence.peer")) {
    check_keys(reader, *table, {"name", "trajectory"});
    const std::string name = text(reader, *table, "name");
    take_name(reader, *table, name, taken);
    if (!table->contains("trajectory")) refuse(reader, *table, "'trajectory' is missing");
    if (!reader.with_peers) continue;
    const fs::path file = *find_path(reader, *table, "trajectory");
    peers.push_back({.name = name, .file = file, .trajectory = read_poses(reader, file)});
  }
  return peers;
}

// What 'path' names; else what 'pull' names, which may have to be fetched.
fs::path sequence_path(const Reader& reader, const toml::table& table) {
  const std::optional<std::string> name = find_text(reader, table, "pull");
  if (!name) {
    const std::optional<fs::path> path = find_path(reader, table, "path");
    if (!path) refuse(reader, table, "'path' is missing");
    return *path;
  }
  if (const std::optional<std::string> path = find_text(reader, table, "path")) {
    fs::path place = (reader.data / *path).lexically_normal();
    std::error_code error;
    if (fs::exists(place, error)) return place;
  }
  if (!reader.pull)
    refuse(reader, *table.get("pull"),
           fmt::format("{} is not below {}; the Python package's edvo downloads it", *name,
                       reader.data.string()));
  return reader.pull(*name);
}

BenchSequence read_sequence(Reader& reader, const toml::table& table,
                            const std::vector<BenchSystem>& systems) {
  check_keys(
      reader, table,
      {"name", "path", "ground_truth", "camera", "depth_scale", "max_frames", "peer", "pull"});
  BenchSequence sequence{
      .name = text(reader, table, "name"), .choice = {}, .truth = {}, .peers = {}};
  constexpr std::int64_t kMostFrames = 1'000'000'000;
  sequence.choice = {
      .path = sequence_path(reader, table),
      .camera_file = find_path(reader, table, "camera"),
      .camera_size = {},
      .depth_scale = find_positive(reader, table, "depth_scale"),
      .first = 0,
      .max_frames = find_count(reader, table, "max_frames", kMostFrames).value_or(0)};
  if (const std::optional<fs::path> truth = find_path(reader, table, "ground_truth"))
    sequence.truth = GroundTruth{truth->string(), read_poses(reader, *truth)};
  sequence.peers = read_peers(reader, table, systems);
  return sequence;
}

}  // namespace

BenchManifest read_manifest(const fs::path& file, const ManifestOptions& options) {
  const toml::table root = parse_toml({file});
  const fs::path base = fs::absolute(file).parent_path();
  Reader reader{{file},
                base,
                options.data.empty() ? base : fs::absolute(options.data),
                options.with_peers,
                {},
                options.pull};
  check_keys(reader, root, {"output", "methods", "repeats", "published", "sequence", "variant"});

  BenchManifest manifest{.file = file,
                         .output = fs::path("bench") / file.stem(),
                         .systems = read_systems(reader, root),
                         .sequences = {},
                         .published = {},
                         .warnings = {}};
  if (const std::optional<std::string> output = find_text(reader, root, "output"))
    manifest.output = (reader.base / *output).lexically_normal();
  if (const std::optional<std::string> published = find_text(reader, root, "published"))
    manifest.published = read_published_tables((reader.base / *published).lexically_normal());
  constexpr std::int64_t kMostRepeats = 1000;
  manifest.repeats =
      static_cast<int>(find_count(reader, root, "repeats", kMostRepeats).value_or(1));
  TakenFolders taken;
  for (const toml::table* table : tables(reader, root, "sequence", "sequence")) {
    manifest.sequences.push_back(read_sequence(reader, *table, manifest.systems));
    take_name(reader, *table, manifest.sequences.back().name, taken);
  }
  if (manifest.sequences.empty())
    refuse(reader, root, "no sequence: [[sequence]] with name and path names what to run on");
  manifest.warnings = std::move(reader.warnings);
  return manifest;
}

}  // namespace edvo::app
