// SPDX-License-Identifier: MIT
#include "interrupt.hpp"

#include <csignal>
#include <mutex>

namespace edvo::python {
namespace {

// Signals belong to the process: so do these.
volatile std::sig_atomic_t is_requested = 0;
struct sigaction before {};
std::mutex mutex;  // of all below
int living = 0;

void request(int /*signal*/) {
  is_requested = 1;
  sigaction(SIGINT, &before, nullptr);
}

}  // namespace

Interrupt::Interrupt() {
  const std::lock_guard lock(mutex);
  if (living++ > 0) return;
  is_requested = 0;
  struct sigaction ours {};
  ours.sa_handler = request;
  sigemptyset(&ours.sa_mask);
  sigaction(SIGINT, nullptr, &before);
  sigaction(SIGINT, &ours, nullptr);
}

Interrupt::~Interrupt() {
  const std::lock_guard lock(mutex);
  if (--living == 0) sigaction(SIGINT, &before, nullptr);
}

bool Interrupt::requested() {
  return is_requested != 0;
}

}  // namespace edvo::python
