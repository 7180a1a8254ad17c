// SPDX-License-Identifier: MIT
#include "edvo/io/model_cache.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/model_file.hpp"
#include "edvo/io/output_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>

namespace edvo {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRemedy = "; the cache can be moved with XDG_CACHE_HOME";

fs::path file_of(const fs::path& folder, std::string_view name, std::string_view extension) {
  return folder / fmt::format("{}{}", name, extension);
}

fs::path describe(const KnownModel& model, const fs::path& folder) {
  const fs::path description = file_of(folder, model.name, ".toml");
  write_whole(description,
              fmt::format("name = \"{0}\"\nfile = \"{0}.onnx\"\nsha256 = \"{1}\"\n"
                          "licence = \"{2}\"\nsource = \"{3}\"\n\n{4}",
                          model.name, model.sha256, model.licence, model.source, model.usage));
  return description;
}

bool is_file_name(const std::string& name) {
  return !name.empty() && name.front() != '.' && name.front() != '-' &&
         std::ranges::all_of(name, [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.';
         });
}

}  // namespace

std::vector<std::string> cached_models(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  std::ranges::sort(names);
  return names;
}

std::optional<fs::path> find_cached_model(const fs::path& folder, const std::string& name) {
  if (folder.empty() || !is_file_name(name)) return std::nullopt;
  std::error_code ignored;
  const fs::path description = file_of(folder, name, ".toml");
  if (!fs::is_regular_file(description, ignored)) return std::nullopt;
  return description;
}

std::optional<fs::path> import_known_model(const fs::path& file, const fs::path& folder,
                                           std::span<const KnownModel> known) {
  std::error_code ignored;
  const std::uintmax_t size = fs::file_size(file, ignored);
  const auto model = std::ranges::find_if(known, [&](const KnownModel& candidate) {
    return static_cast<std::uintmax_t>(candidate.bytes) == size;
  });
  if (model == known.end()) return std::nullopt;
  const std::string bytes = read_model_file(file);
  if (sha256(bytes) != model->sha256) return std::nullopt;
  make_folder(folder, kRemedy);
  const fs::path place = file_of(folder, model->name, ".onnx");
  if (!fs::equivalent(file, place, ignored)) write_whole(place, bytes);
  return describe(*model, folder);
}

fs::path import_model(const fs::path& description, const fs::path& onnx, const fs::path& folder,
                      bool replace) {
  ModelDescription imported =
      model_description_from_toml(read_model_file(description), description.string());
  if (imported.name.empty()) imported.name = onnx.stem().string();
  if (!is_file_name(imported.name))
    throw Error(ErrorCode::kModel,
                fmt::format("{}: name '{}' is no file name; letters, digits, '-', '_' and '.' are",
                            description.string(), imported.name));
  if (find_known_model(imported.name) != nullptr)
    throw Error(ErrorCode::kModel, fmt::format("{}: name '{}' belongs to a known model; choose "
                                               "another",
                                               description.string(), imported.name));
  if (!replace && find_cached_model(folder, imported.name))
    throw Error(ErrorCode::kModel,
                fmt::format("{}: there is a model '{}' already; replace it with --force or choose "
                            "another name",
                            folder.string(), imported.name));
  const std::string bytes = read_model_file(onnx);
  const std::string hash = sha256(bytes);
  if (!imported.sha256.empty() && imported.sha256 != hash)
    throw Error(ErrorCode::kModel,
                fmt::format("{}: its SHA-256 is {}, but {} expects {}", onnx.string(), hash,
                            description.string(), imported.sha256));
  imported.file = imported.name + ".onnx";
  imported.sha256 = hash;
  make_folder(folder, kRemedy);
  const fs::path target = file_of(folder, imported.name, ".toml");
  std::error_code ignored;
  fs::remove(target, ignored);  // must not describe other weights, not even for a moment
  write_whole(folder / imported.file, bytes);
  write_whole(target, to_toml(imported));
  return target;
}

}  // namespace edvo
