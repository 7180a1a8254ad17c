// SPDX-License-Identifier: MIT
#include "stop_signal.hpp"

#include <csignal>
#include <cstdlib>

namespace edvo::app {
namespace {

// The only thing that a signal handler may touch.
volatile std::sig_atomic_t stop = 0;

constexpr int kStops[] = {SIGINT, SIGTERM, SIGHUP};

void leave(int) {
  std::_Exit(kInterruptedStatus);
}

void request_stop(int signal) {
  stop = 1;
  std::signal(signal, leave);
}

void handle(void (*handler)(int)) {
  for (const int signal : kStops) {
    struct sigaction now {};
    const bool is_known = sigaction(signal, nullptr, &now) == 0;
    // nohup has asked for it. A shell also has what it starts with & ignore Ctrl-C; but then who
    // sends SIGINT means this program.
    const bool is_ignored = signal == SIGHUP && is_known && now.sa_handler == SIG_IGN;
    if (!is_ignored) std::signal(signal, handler);
  }
}

}  // namespace

void leave_on_signals() {
  handle(leave);
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

StopSignal::StopSignal() {
  handle(request_stop);
}

StopSignal::~StopSignal() {
  handle(leave);
}

bool stop_requested() {
  return stop != 0;
}

}  // namespace edvo::app
