// SPDX-License-Identifier: MIT
#include "stop_signal.hpp"

#include <csignal>

namespace edvo::app {
namespace {

// The only thing that a signal handler may touch.
volatile std::sig_atomic_t stop = 0;

void request_stop(int signal) {
  stop = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

StopSignal::StopSignal() {
  stop = 0;
  std::signal(SIGINT, request_stop);
  std::signal(SIGTERM, request_stop);
}

StopSignal::~StopSignal() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool stop_requested() {
  return stop != 0;
}

}  // namespace edvo::app
