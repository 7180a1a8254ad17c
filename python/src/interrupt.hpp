// SPDX-License-Identifier: MIT
// Ctrl-C as a question that can be asked between two frames.
#pragma once

namespace edvo::python {

// While one lives, the first SIGINT only makes requested() true; the next one is Python's again, as
// all are afterwards.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] static bool requested();
};

}  // namespace edvo::python
