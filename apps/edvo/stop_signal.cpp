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

StopSignal::StopSignal()
    : before_interrupt_(std::signal(SIGINT, request_stop)),
      before_terminate_(std::signal(SIGTERM, request_stop)) {
  stop = 0;
}

StopSignal::~StopSignal() {
  std::signal(SIGINT, before_interrupt_);
  std::signal(SIGTERM, before_terminate_);
}

bool stop_requested() {
  return stop != 0;
}

}  // namespace edvo::app
