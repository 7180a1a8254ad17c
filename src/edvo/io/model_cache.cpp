// SPDX-License-Identifier: MIT
#include "edvo/io/model_cache.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/download.hpp"
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

// Empty, or why these bytes are not the model.
std::string difference(const KnownModel& model, const std::string& bytes) {
  if (static_cast<std::int64_t>(bytes.size()) != model.bytes)
    return fmt::format("{} bytes instead of {}", bytes.size(), model.bytes);
  const std::string found = sha256(bytes);
  if (found == model.sha256) return {};
  return fmt::format("its SHA-256 is {} instead of {}", found, model.sha256);
}

bool is_whole(const KnownModel& model, const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && difference(model, read_model_file(file)).empty();
}

fs::path describe(const KnownModel& model, const fs::path& folder) {
  const fs::path description = file_of(folder, model.name, ".toml");
  write_whole(description,
              fmt::format("name = \"{0}\"\nfile = \"{0}.onnx\"\nsha256 = \"{1}\"\n"
                          "licence = \"{2}\"\nsource = \"{3}\"\n\n{4}",
                          model.name, model.sha256, model.licence, model.source, model.usage));
  return description;
}

void move_over(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error)
    throw Error(ErrorCode::kOutput,
                fmt::format("{}: cannot be written: {}", to.string(), error.message()));
}

bool holds_nothing(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  return error || size == 0;
}

// False if it was stopped.
bool fetch(const KnownModel& model, std::string address, const fs::path& file,
           const PullOptions& options) {
  fs::path part = file;
  part += ".part";
  std::error_code ignored;
  const bool continues = !holds_nothing(part);
  try {
    if (!download({.url = std::move(address),
                   .bytes = model.bytes,
                   .max_lost_frames = options.max_lost_frames,
                   .on_progress = options.on_progress},
                  part))
      return false;
  } catch (const Error&) {
    if (holds_nothing(part)) fs::remove(part, ignored);
    throw;
  }
  const std::string wrong = difference(model, read_model_file(part));
  if (wrong.empty()) {
    move_over(part, file);
    return true;
  }
  fs::remove(part, ignored);
  throw Error(ErrorCode::kModel,
              fmt::format("not the model {}: {}; it was not kept{}", model.name, wrong,
                          continues ? ", the same command starts anew" : ""));
}

// One address after the other.
bool fetch_anywhere(const KnownModel& model, const fs::path& file, const PullOptions& options) {
  std::vector<std::string> addresses(model.addresses.begin(), model.addresses.end());
  if (!options.address.empty()) addresses = {options.address};
  for (std::size_t i = 0;; ++i) {
    try {
      if (options.on_note) options.on_note("from " + addresses[i]);
      return fetch(model, addresses[i], file, options);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kModel || i + 1 == addresses.size()) throw;
      if (options.on_note) options.on_note(error.what());
    }
  }
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

std::optional<fs::path> pull_model(const KnownModel& model, const fs::path& folder,
                                   const PullOptions& options) {
  make_folder(folder, kRemedy);
  const fs::path file = file_of(folder, model.name, ".onnx");
  if (is_whole(model, file)) {
    if (options.on_note) options.on_note("already there");
  } else if (!fetch_anywhere(model, file, options)) {
    return std::nullopt;
  }
  return describe(model, folder);
}

fs::path pull_model_from(const KnownModel& model, const fs::path& folder, const fs::path& file) {
  const std::string bytes = read_model_file(file);
  if (const std::string wrong = difference(model, bytes); !wrong.empty())
    throw Error(ErrorCode::kModel,
                fmt::format("{}: not the model {}: {}; an own network is imported with edvo models "
                            "import",
                            file.string(), model.name, wrong));
  make_folder(folder, kRemedy);
  write_whole(file_of(folder, model.name, ".onnx"), bytes);
  return describe(model, folder);
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
                                               "another, or fetch that with edvo models pull {}",
                                               description.string(), imported.name, imported.name));
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
