// SPDX-License-Identifier: MIT
// edvo cache [clear]: where unpacked archives are kept, and how to be rid of them.
#include "cache_folder.hpp"
#include "commands.hpp"
#include "edvo/core/error.hpp"
#include "edvo/io/archive_cache.hpp"
#include "terminal.hpp"

namespace edvo::app {
namespace {

std::filesystem::path known_cache() {
  const std::filesystem::path cache = cache_folder();
  if (cache.empty())
    throw Error(ErrorCode::kOutput, "no cache is known; set XDG_CACHE_HOME or HOME");
  return cache;
}

double megabytes(std::uintmax_t bytes) {
  return static_cast<double>(bytes) / 1e6;
}

void list() {
  const std::filesystem::path cache = known_cache();
  print("{}\n", cache.string());
  std::uintmax_t total = 0;
  for (const CachedArchive& archive : cached_archives(cache)) {
    print("{:10.1f} MB  {}\n", megabytes(archive.bytes), archive.folder.filename().string());
    total += archive.bytes;
  }
  print("{:10.1f} MB  in all, of unpacked archives; edvo cache clear removes them\n",
        megabytes(total));
}

void clear() {
  std::uintmax_t total = 0;
  for (const CachedArchive& archive : cached_archives(known_cache())) {
    remove_cached(archive);
    total += archive.bytes;
  }
  print("{:.1f} MB removed\n", megabytes(total));
}

}  // namespace

void add_cache_command(CLI::App& program) {
  CLI::App* verb = program.add_subcommand(
      "cache", "List the archives that were unpacked, and where; `clear` removes them");
  CLI::App* clearing = verb->add_subcommand("clear", "remove all of them; models stay");
  clearing->callback(clear);
  verb->require_subcommand(0, 1);
  verb->callback([verb] {
    if (verb->get_subcommands().empty()) list();
  });
}

}  // namespace edvo::app
