// SPDX-License-Identifier: MIT
// edvo report RUN...
#include "commands.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/report/comparison.hpp"
#include "edvo/report/html.hpp"
#include "edvo/report/stored_run.hpp"
#include "terminal.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::vector<std::string> runs;
  std::string output;  // empty = as the help says
};

void report(const Arguments& arguments) {
  std::vector<StoredRun> runs;
  for (const std::string& folder : arguments.runs) {
    runs.push_back(read_run(folder));
    for (const std::string& missing : runs.back().missing)
      say("warning: {}: {}\n", folder, missing);
  }
  const StoredRun& first = runs.front();
  const bool is_one = runs.size() == 1;
  const std::string page =
      is_one ? to_html(first.summary, first.log, first.outcome) : comparison_page(runs);
  fs::path output = is_one ? first.folder / "report.html" : fs::path("comparison.html");
  if (!arguments.output.empty()) output = arguments.output;
  write_whole(output, page);
  print("report     {}\n", output.string());
}

}  // namespace

void add_report_command(CLI::App& program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand(
      "report", "Compare finished runs on one page, or make the report of one run anew");
  command->add_option("runs", arguments->runs, "Folders that edvo run has written")
      ->required()
      ->type_name("RUN");
  command
      ->add_option("-o,--output", arguments->output,
                   "The page; without it comparison.html, of one run the report.html in its folder")
      ->type_name("FILE");
  command->callback([arguments] { report(*arguments); });
}

}  // namespace edvo::app
