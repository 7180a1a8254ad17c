// SPDX-License-Identifier: MIT
// Ctrl-C, SIGTERM and a closed terminal as a question that can be asked between two frames.
#pragma once

namespace edvo::app {

// What a shell expects of a program that was stopped by Ctrl-C.
inline constexpr int kInterruptedStatus = 130;

// To be called first: from now on such a signal ends the program with kInterruptedStatus. What the
// system would rather end it for (a closed pipe, a file as large as ulimit -f allows) becomes an
// error of the function that writes.
void leave_on_signals();

// While it lives, the first such signal only makes stop_requested() true, for good; the next one
// ends the program.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
};

[[nodiscard]] bool stop_requested();

}  // namespace edvo::app
