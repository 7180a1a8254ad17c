// SPDX-License-Identifier: MIT
// What `edvo bench` is asked to do: a TOML file, read and checked as a whole before anything runs.
#pragma once

#include "edvo/core/trajectory.hpp"
#include "edvo/odometry/config.hpp"
#include "published_tables.hpp"
#include "sequence_input.hpp"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace edvo::app {

// One of our systems: a method, or a variant of one with other options.
struct BenchSystem {
  std::string name;
  std::string method;
  std::vector<std::string> set;  // what a variant changes, "group.field=value"
  Config config;                 // resolved
};

// The trajectory of another system on the same frames.
struct BenchPeer {
  std::string name;
  std::filesystem::path file;
  Trajectory trajectory;
};

struct BenchSequence {
  std::string name;
  SequenceChoice choice;
  std::optional<GroundTruth> truth;  // none = the sequence's own
  std::vector<BenchPeer> peers;
};

struct BenchManifest {
  std::filesystem::path file;
  std::filesystem::path output;  // folder of the runs
  int repeats = 1;
  std::vector<BenchSystem> systems;  // methods, then variants
  std::vector<BenchSequence> sequences;
  std::optional<PublishedTables> published;  // to print beside what is measured
  std::vector<std::string> warnings;
};

struct ManifestOptions {
  std::filesystem::path data;  // where relative paths of data start, empty = beside the manifest
  bool with_peers = true;
  // Where the public sequence of a name is, fetched if it is missing; null = nothing is fetched.
  std::function<std::filesystem::path(const std::string&)> pull = nullptr;
};

// Throws Error(kConfig) "file:line: ..." at whatever is unknown, of the wrong type, missing or said
// twice, and Error(kInput) for trajectories that cannot be read.
[[nodiscard]] BenchManifest read_manifest(const std::filesystem::path& file,
                                          const ManifestOptions& options);

}  // namespace edvo::app
