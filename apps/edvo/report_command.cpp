// SPDX-License-Identifier: MIT
// edvo report RUN...
#include "commands.hpp"
#include "edvo/io/output_file.hpp"
#include "edvo/report/comparison.hpp"
#include "edvo/report/html.hpp"
#include "edvo/report/stored_run.hpp"
#include "output_name.hpp"
#include "terminal.hpp"

#include <memory>
#include <string>
#include <vector>

namespace edvo::app {
namespace {

struct Arguments {
  std::vector<std::string> runs;
  std::string output;  // empty = as the help says
  bool force = false;
};

void report(const Arguments& arguments) {
  const bool is_one = arguments.runs.size() == 1;
  std::string output = arguments.output;
  if (output.empty() && !is_one) output = "comparison.html";
  require_ending("-o", output, {".html", ".htm"});
  require_new("-o", output, arguments.force);
  std::vector<StoredRun> runs;
  for (const std::string& folder : arguments.runs) {
    runs.push_back(read_run(folder));
    for (const std::string& missing : runs.back().missing)
      say("warning: {}: {}\n", folder, missing);
  }
  const StoredRun& first = runs.front();
  const std::string page =
      is_one ? to_html(first.summary, first.log, first.outcome) : comparison_page(runs);
  if (output.empty()) output = (first.folder / "report.html").string();
  write_whole(output, page);
  print("report     {}\n", output);
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
      ->type_name("FILE.html");
  command->add_flag("--force", arguments->force, "Replace a page that is there");
  command->callback([arguments] { report(*arguments); });
}

}  // namespace edvo::app
