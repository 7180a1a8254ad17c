// SPDX-License-Identifier: MIT
// edvo eval GROUND_TRUTH ESTIMATE...
#include "commands.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/io/trajectory_file.hpp"
#include "enum_option.hpp"
#include "eval_plots.hpp"
#include "eval_tables.hpp"
#include "output_name.hpp"
#include "terminal.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string truth;
  std::vector<std::string> estimates;
  std::string alignment = "se3", protocol = "tum", format = "text";
  std::string delta;  // empty = what the protocol is known for
  EvalOptions options;
  std::string plot_folder;
  bool json = false, force = false;
};

// The command line has checked that the name is one of names_of().
template <typename Enum>
Enum named(std::string_view wanted) {
  if (const std::optional<Enum> value = find_named<Enum>(wanted)) return *value;
  throw Error(ErrorCode::kInternal, fmt::format("no value is named {}", wanted));
}

EvalOptions options_from(const Arguments& arguments) {
  EvalOptions options = arguments.options;
  options.alignment = named<AlignmentKind>(arguments.alignment);
  options.association.protocol = named<Protocol>(arguments.protocol);
  if (!arguments.delta.empty()) {
    options.rpe.delta = parse_delta(arguments.delta);
  } else if (options.association.protocol == Protocol::kEvo) {
    options.rpe.delta = {.value = 1, .unit = DeltaUnit::kFrames};
  }
  return options;
}

// A run's folder stands for its trajectory.
std::string trajectory_in(const std::string& place) {
  std::error_code ignored;
  const fs::path inside = fs::path(place) / "trajectory.tum";
  return fs::is_regular_file(inside, ignored) ? inside.string() : place;
}

// File names without folder and ending where that tells them apart, else paths.
std::vector<std::string> short_names(const std::vector<std::string>& files) {
  std::vector<std::string> names;
  for (const std::string& file : files) {
    fs::path path = fs::path(file).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();
    const bool is_run = trajectory_in(file) != file;
    names.push_back((is_run ? path.filename() : path.stem()).string());
  }
  const std::set<std::string> distinct(names.begin(), names.end());
  return distinct.size() == names.size() ? names : files;
}

Trajectory read_with_warnings(const std::string& file) {
  TrajectoryFile read = read_trajectory(file);
  for (const std::string& warning : read.warnings) say("warning: {}\n", warning);
  return std::move(read.trajectory);
}

NamedEvaluation evaluate_file(const Trajectory& truth, const std::string& place,
                              const std::string& name, const EvalOptions& options) {
  const std::string file = trajectory_in(place);
  NamedEvaluation result{
      .name = name, .file = file, .estimate = read_with_warnings(file), .evaluation = {}};
  try {
    result.evaluation = evaluate(truth, result.estimate, options);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kEvaluation) throw;
    throw Error(error.code(), fmt::format("{}: {}", file, error.what()));
  }
  for (const std::string& warning : result.evaluation.warnings)
    say("warning: {}: {}\n", file, warning);
  return result;
}

constexpr std::array kPlots = {"trajectory.svg", "ate.svg", "rpe_translation.svg",
                               "rpe_rotation.svg"};

void require_new_plots(const fs::path& folder, bool force) {
  if (!fs::exists(folder)) return;
  for (const char* plot : kPlots) require_new("--plot", (folder / plot).string(), force);
}

void write_plots(const fs::path& folder, const Trajectory& truth,
                 const std::vector<NamedEvaluation>& evaluations) {
  make_folder(folder);
  const std::array plots = {trajectory_plot(truth, evaluations), ate_plot(evaluations),
                            rpe_translation_plot(evaluations), rpe_rotation_plot(evaluations)};
  for (std::size_t i = 0; i < kPlots.size(); ++i) write_whole(folder / kPlots[i], to_svg(plots[i]));
  say("plots: {}\n", (folder / "*.svg").string());
}

// With several estimates one line for all, with EST where a file goes.
std::string evo_line(const std::string& truth_file,
                     const std::vector<NamedEvaluation>& evaluations) {
  const NamedEvaluation& first = evaluations.front();
  const std::vector<std::string> commands =
      evo_commands(truth_file, evaluations.size() == 1 ? first.file : "EST", first.estimate,
                   first.evaluation.options);
  return fmt::format("{}", fmt::join(commands, " && "));
}

void print_table(const std::string& truth_file, TableFormat format,
                 const std::vector<NamedEvaluation>& evaluations) {
  const EvalOptions& options = evaluations.front().evaluation.options;
  print("{}{}{}{}", format_note(describe_protocol(options), format),
        format_note("coverage = " + describe_coverage(options), format),
        format_table(evaluation_table(evaluations), format),
        format_command("with evo: ", evo_line(truth_file, evaluations), format));
}

// Sim(3) where the estimate fits much better with another scale.
std::string scale_hint(const Trajectory& truth, const NamedEvaluation& named) {
  constexpr double kTolerance = 0.02, kExplained = 0.5;  // of the scale; of the error
  const Evaluation& evaluation = named.evaluation;
  if (evaluation.options.alignment != AlignmentKind::kSe3) return "";
  const Ate scaled =
      absolute_trajectory_error(truth, named.estimate, evaluation.matches, AlignmentKind::kSim3);
  const double scale = scaled.truth_from_estimate.scale;
  const double rmse = evaluation.ate.distance.rmse;
  if (std::abs(scale - 1) <= kTolerance || !(scaled.distance.rmse < kExplained * rmse)) return "";
  return fmt::format(
      "warning: {}: scaled by {:.4g} it fits with an ATE of {:.4g} m instead of "
      "{:.4g} m (--align sim3): was its depth scale right?\n",
      named.file, scale, scaled.distance.rmse, rmse);
}

// One that cannot be compared hides no other; the first such error ends the verb.
std::vector<NamedEvaluation> evaluate_each(const Arguments& arguments, const Trajectory& truth,
                                           std::optional<Error>& failure) {
  const EvalOptions options = options_from(arguments);
  const std::vector<std::string> names = short_names(arguments.estimates);
  std::vector<NamedEvaluation> evaluations;
  for (std::size_t i = 0; i < names.size(); ++i) try {
      evaluations.push_back(evaluate_file(truth, arguments.estimates[i], names[i], options));
      say("{}", scale_hint(truth, evaluations.back()));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kEvaluation) throw;
      if (failure) say("edvo: {}\n", failure->what());
      failure = error;
    }
  if (evaluations.empty()) throw Error(*failure);
  return evaluations;
}

void evaluate_all(const Arguments& arguments) {
  (void)options_from(arguments);  // before files are read
  if (!arguments.plot_folder.empty()) require_new_plots(arguments.plot_folder, arguments.force);
  const Trajectory truth = read_with_warnings(arguments.truth);
  std::optional<Error> failure;
  const std::vector<NamedEvaluation> evaluations = evaluate_each(arguments, truth, failure);
  if (arguments.json || arguments.format == "json") {
    print_bytes(evaluation_json(arguments.truth, truth, evaluations));
  } else {
    print_table(arguments.truth, named<TableFormat>(arguments.format), evaluations);
  }
  if (!arguments.plot_folder.empty()) write_plots(arguments.plot_folder, truth, evaluations);
  if (failure) throw Error(*failure);
}

}  // namespace

void add_eval_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "eval", "Errors of trajectories (TUM or EuRoC format) against ground truth: ATE, RPE, drift");
  const auto arguments = std::make_shared<Arguments>();
  std::vector<std::string> formats = names_of<TableFormat>();
  formats.emplace_back("json");
  EvalOptions& options = arguments->options;

  command->add_option("GT", arguments->truth, "ground truth trajectory")->required();
  command->add_option("EST", arguments->estimates, "estimated trajectories, or folders of edvo run")
      ->required();
  command->add_option("--align", arguments->alignment, "alignment before ATE")
      ->check(CLI::IsMember(names_of<AlignmentKind>()))
      ->capture_default_str();
  command->add_option("--delta", arguments->delta,
                      "RPE between poses so far apart: 1s 30f 0.5m 0.1rad 10deg, or all pairs: all "
                      "(default 1s; 1f with --protocol evo)");
  command
      ->add_option("--max-diff", options.association.max_difference,
                   "poses match if their stamps are closer than this [s]")
      ->capture_default_str();
  command
      ->add_option("--offset", options.association.offset,
                   "added to the stamps of the estimates [s]")
      ->capture_default_str();
  command->add_option("--protocol", arguments->protocol, "whose rules: TUM scripts or evo")
      ->check(CLI::IsMember(names_of<Protocol>()))
      ->capture_default_str();
  command->add_option("--frames", options.frames,
                      "images the estimates were made from; coverage is then poses / frames");
  command
      ->add_option("--max-pairs", options.rpe.max_pairs,
                   "of more RPE pairs so many are drawn by chance, 0 = no limit")
      ->capture_default_str();
  command->add_option("--seed", options.rpe.seed, "of that draw")->capture_default_str();
  command->add_option("--format", arguments->format, "what to print")
      ->check(CLI::IsMember(formats))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "same as --format json");
  command->add_option("--plot", arguments->plot_folder, "write plots (SVG) into this folder");
  command->add_flag("--force", arguments->force, "replace plots that are there");
  command->callback([arguments] { evaluate_all(*arguments); });
}

}  // namespace edvo::app
