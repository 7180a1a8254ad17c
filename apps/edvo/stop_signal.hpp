// SPDX-License-Identifier: MIT
// Ctrl-C and SIGTERM as a question that can be asked between two frames.
#pragma once

namespace edvo::app {

// While it lives, the first such signal only makes stop_requested() true; the next one
// ends the program as usual.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

 private:
  using Handler = void (*)(int);
  Handler before_interrupt_, before_terminate_;
};

[[nodiscard]] bool stop_requested();

// What a shell expects of a program that was stopped by Ctrl-C.
inline constexpr int kInterruptedStatus = 130;

}  // namespace edvo::app
