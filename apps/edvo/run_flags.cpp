// SPDX-License-Identifier: MIT
#include "run_flags.hpp"

namespace edvo::app {

void add_run_flags(CLI::App& command, RunFlags& flags) {
  constexpr int kMostThreads = 256;
  add_config_flags(command, flags.config);
  command
      .add_option("-o,--output", flags.output,
                  "Folder for the results, default runs/<sequence>/<UTC time>")
      ->type_name("DIR");
  command.add_flag("--force", flags.force,
                   "Replace what an earlier run has left: its folder, map and points");
  command
      .add_option("--edge-cache", flags.edge_cache,
                  "Folder that keeps the network's edge maps for the next run")
      ->type_name("DIR");
  command
      .add_option("--points", flags.points,
                  "Write the keyframes' points with colour, as PLY, by the final poses")
      ->type_name("FILE.ply");
  command
      .add_option("--map", flags.map,
                  "A saved map, in whose frame the poses are where the camera was in it")
      ->type_name("FILE");
  command.add_flag("--update-map", flags.update_map, "Add this run to the map of --map");
  command.add_option("--save-map", flags.save_map, "Write the map: keyframes, images and links")
      ->type_name("FILE");
  command.add_option("--threads", flags.threads, "1, or more to read images ahead of their use")
      ->type_name("N")
      ->check(CLI::Range(1, kMostThreads))
      ->capture_default_str();
  command.add_flag("--no-loops", flags.no_loops,
                   "The odometry alone: look for no places that were seen before");
  command.add_flag("--no-final-pass", flags.no_final_pass,
                   "Do not refine all keyframes together at the end "
                   "(window.final_iterations=0)");
  command.add_flag("--json", flags.json, "Print the summary as one JSON object");
  command.add_flag("--no-report", flags.no_report, "Do not write report.html");
  command.add_flag("--quiet", flags.quiet, "No notes and no progress; warnings stay");
  command.add_flag("--profile", flags.profile, "Print where the time went, stage by stage");
}

Config resolve_config(const RunFlags& flags) {
  Config config = resolve_config(flags.config);
  if (flags.no_final_pass) config.window.final_iterations = 0;
  return config;
}

std::string method_name(const RunFlags& flags) {
  return std::string(name_of(chosen_method(flags.config)));
}

}  // namespace edvo::app
