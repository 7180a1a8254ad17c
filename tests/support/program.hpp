// SPDX-License-Identifier: MIT
// Runs the edvo program as a user would.
#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace edvo::test {

struct ProgramResult {
  int status = -1;     // exit status, -1 if it was killed
  std::string output;  // stdout; with 2>&1 in the arguments, stderr too
};

// Through the shell, so that arguments may hold redirections; the caller quotes.
inline ProgramResult run_edvo(const std::string& arguments) {
  ProgramResult result;
  FILE* pipe = popen((std::string(EDVO_PROGRAM) + " " + arguments).c_str(), "r");
  if (!pipe) return result;
  char buffer[4096];
  while (const std::size_t n = fread(buffer, 1, sizeof buffer, pipe))
    result.output.append(buffer, n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.status = WEXITSTATUS(status);
  return result;
}

}  // namespace edvo::test
