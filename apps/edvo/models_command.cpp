// SPDX-License-Identifier: MIT
// edvo models list|verify|import|path
#include "commands.hpp"
#include "edvo/core/did_you_mean.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/model_cache.hpp"
#include "edvo/io/model_file.hpp"
#include "edvo/network/edge_network.hpp"
#include "model_choice.hpp"
#include "terminal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

namespace edvo::app {
namespace {

namespace fs = std::filesystem;

// What is known of a model, whether it is there or not.
struct Row {
  std::string name, state, licence, source;
  std::int64_t bytes = 0;  // 0 = not known
  std::vector<std::string> addresses = {};
};

std::string size_text(std::int64_t bytes) {
  constexpr double kMegabyte = 1e6;
  if (bytes == 0) return "-";
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / kMegabyte);
}

std::int64_t size_of(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  return error ? 0 : static_cast<std::int64_t>(size);
}

Row row_of_known(const KnownModel& model, const fs::path& folder) {
  const std::string name(model.name);
  const std::string state = find_cached_model(folder, name) ? "ready" : "not there";
  return {name,
          state,
          std::string(model.licence),
          std::string(model.source),
          model.bytes,
          {model.addresses.begin(), model.addresses.end()}};
}

Row row_of_own(const std::string& name, const fs::path& folder) {
  try {
    const fs::path file = *find_cached_model(folder, name);
    const ModelDescription model = read_description(file);
    const std::int64_t bytes = size_of(folder / model.file);
    return {name, bytes > 0 ? "ready" : "no weights", model.licence, model.source, bytes};
  } catch (const Error& error) {
    return {name, "damaged", "", error.what(), 0};
  }
}

std::vector<Row> rows(const fs::path& folder) {
  std::vector<Row> rows;
  for (const KnownModel& model : known_models()) rows.push_back(row_of_known(model, folder));
  for (const std::string& name : cached_models(folder))
    if (find_known_model(name) == nullptr) rows.push_back(row_of_own(name, folder));
  return rows;
}

void list(bool json) {
  const fs::path folder = models_folder();
  if (json) {
    nlohmann::json models = nlohmann::json::array();
    for (const Row& row : rows(folder))
      models.push_back({{"name", row.name},
                        {"state", row.state},
                        {"bytes", row.bytes},
                        {"licence", row.licence},
                        {"source", row.source},
                        {"addresses", row.addresses}});
    print_bytes(nlohmann::json{{"folder", folder.string()}, {"models", models}}.dump(
                    2, ' ', false, nlohmann::json::error_handler_t::replace) +
                '\n');
    return;
  }
  print("{:<16} {:<12} {:>9}  {:<8} {}\n", "model", "state", "size", "licence", "source");
  for (const Row& row : rows(folder))
    print("{:<16} {:<12} {:>9}  {:<8} {}\n", row.name, row.state, size_text(row.bytes),
          row.licence.empty() ? "-" : row.licence, row.source.empty() ? "-" : row.source);
}

fs::path cached(const fs::path& folder, const std::string& name) {
  if (const auto description = find_cached_model(folder, name)) return *description;
  const bool is_known = find_known_model(name) != nullptr;
  const std::vector<std::string> names = cached_models(folder);
  throw Error(
      ErrorCode::kModel,
      is_known
          ? fmt::format("model {} is not there; {}", name, how_to_get(name))
          : fmt::format("there is no model {}{}; there are: {}", name, did_you_mean(name, names),
                        names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "))));
}

// Every file is looked at, then the first failure decides.
void verify(const std::string& name) {
  const fs::path folder = models_folder();
  const std::vector<std::string> names =
      name.empty() ? cached_models(folder) : std::vector<std::string>{name};
  if (names.empty()) print("no models in {}\n", folder.string());
  std::string first_failure;
  for (const std::string& each : names) {
    try {
      const Model model = read_model(cached(folder, each));
      print("{}: {}\n", each, model.description.sha256.empty() ? "readable, no hash given" : "ok");
    } catch (const Error& error) {
      print("{}: {}\n", each, error.what());
      if (first_failure.empty()) first_failure = each;
    }
  }
  if (!first_failure.empty())
    throw Error(ErrorCode::kModel, fmt::format("model {} is damaged; {}", first_failure,
                                               find_known_model(first_failure) != nullptr
                                                   ? how_to_get(first_failure)
                                                   : "import it again with --force"));
}

struct ImportArguments {
  fs::path onnx, description;
  bool force = false;
};

// A network that cannot run is refused here and not at its first use.
void try_out(const fs::path& description, const fs::path& onnx) {
  const Model model = read_model(description, onnx);
  const cv::Size size = model.description.input.size;
  (void)make_network_strength(model, size.empty() ? cv::Size(320, 240) : size);
}

void import(const ImportArguments& arguments) {
  fs::path description = arguments.description;
  if (description.empty()) {
    if (const auto known = import_known_model(arguments.onnx, models_folder())) {
      print("{}\n", known->string());
      return;
    }
    description = fs::path(arguments.onnx).replace_extension(".toml");
  }
  std::error_code ignored;
  if (!fs::exists(description, ignored) && fs::exists(arguments.onnx, ignored))
    throw Error(
        ErrorCode::kModel,
        fmt::format("{}: no such file, and by size and SHA-256 {} is no model that edvo knows; an "
                    "own network needs a description (docs/models.md), beside it or with "
                    "--description FILE",
                    description.string(), arguments.onnx.string()));
  try_out(description, arguments.onnx);
  print("{}\n",
        import_model(description, arguments.onnx, models_folder(), arguments.force).string());
}

void add_import(CLI::App& models) {
  const auto arguments = std::make_shared<ImportArguments>();
  CLI::App* verb = models.add_subcommand(
      "import", "Put a known model's file, or an own network, into the cache");
  verb->add_option("file", arguments->onnx, "ONNX file")->required()->type_name("FILE");
  verb->add_option("--description", arguments->description, "Default: the .toml beside it")
      ->type_name("FILE");
  verb->add_flag("--force", arguments->force, "Replace the model of that name");
  verb->callback([arguments] { import(*arguments); });
}

}  // namespace

void add_models_command(CLI::App& program) {
  CLI::App* models = program.add_subcommand("models", "List, check and import edge networks");
  models->require_subcommand(1);

  const auto json = std::make_shared<bool>(false);
  CLI::App* list_verb = models->add_subcommand("list", "What is known and what is there");
  list_verb->add_flag("--json", *json, "Print one JSON object");
  list_verb->callback([json] { list(*json); });

  const auto to_verify = std::make_shared<std::string>();
  CLI::App* verify_verb = models->add_subcommand("verify", "Check the hashes of what is there");
  verify_verb->add_option("name", *to_verify, "Only this model");
  verify_verb->callback([to_verify] { verify(*to_verify); });

  add_import(*models);

  const auto to_find = std::make_shared<std::string>();
  CLI::App* path_verb = models->add_subcommand("path", "Print where a model's description is");
  path_verb->add_option("name", *to_find, "As edvo models list shows it")->required();
  path_verb->callback([to_find] { print("{}\n", cached(models_folder(), *to_find).string()); });
}

}  // namespace edvo::app
