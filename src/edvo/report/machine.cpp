// SPDX-License-Identifier: MIT
#include "edvo/report/machine.hpp"

#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <Eigen/Core>
#include <opencv2/core/version.hpp>

#include <fstream>
#include <thread>

namespace edvo {
namespace {

// The value of the first line "KEY<separator>VALUE" whose key is the one asked for, without quotes.
std::string value_in(const char* file, const std::string& key, char separator) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t split = line.find(separator);
    if (split == std::string::npos || line.compare(0, key.size(), key) != 0) continue;
    const std::size_t first = line.find_first_not_of(" \t\"", split + 1);
    if (first == std::string::npos) continue;
    return line.substr(first, line.find_last_not_of(" \t\"") + 1 - first);
  }
  return "unknown";
}

std::string kernel() {
  utsname names{};
  if (uname(&names) != 0) return "unknown";
  return fmt::format("{} {} {}", names.sysname, names.release, names.machine);
}

}  // namespace

Machine this_machine() {
#if defined(__clang__)
  const std::string compiler = "clang " __clang_version__;
#else
  const std::string compiler = "gcc " __VERSION__;
#endif
  return {.edvo = EDVO_VERSION,
          .compiler = compiler,
          .opencv = CV_VERSION,
          .eigen = fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                               EIGEN_MINOR_VERSION),
          .processor = value_in("/proc/cpuinfo", "model name", ':'),
          .hardware_threads = static_cast<int>(std::thread::hardware_concurrency()),
          .operating_system =
              fmt::format("{}, {}", value_in("/etc/os-release", "PRETTY_NAME", '='), kernel())};
}

double peak_memory() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  constexpr double kBytesPerUnit = 1024;  // Linux counts in KiB
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-union-access): glibc declares it so
  return static_cast<double>(usage.ru_maxrss) * kBytesPerUnit * 1e-6;
}

}  // namespace edvo
