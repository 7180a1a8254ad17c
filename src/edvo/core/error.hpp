// SPDX-License-Identifier: MIT
// The one exception type: bad input from outside, said as what, where and which value.
#pragma once

#include <stdexcept>
#include <string>

namespace edvo {

// Each code is also the exit status of the command-line program (docs/errors.md).
enum class ErrorCode {
  kInternal = 1,      // a bug: not the user's fault
  kUsage = 2,         // command line: unknown verb, option or value
  kInput = 3,         // data set: missing, empty or malformed folder, list or image
  kConfig = 4,        // configuration: unknown key, wrong type, value out of range
  kCalibration = 5,   // camera: missing, unreadable or impossible intrinsics
  kModel = 6,         // edge network: file, hash, description or shape does not fit
  kOutput = 7,        // results cannot be written: disk full, no permission
  kEvaluation = 8,    // trajectories that cannot be compared: no overlap, too few poses
  kTrackingLost = 9,  // the run ended with no pose at all
  kResources = 10,    // the system gives no more memory, threads or open files
  kMap = 11,          // map: damaged, newer, in use, of another camera, or of another place
};

// Thrown with a message of the form "where: what, value; how to mend it".
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  [[nodiscard]] ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

// To be called in a catch block: what was caught, as an Error. Whatever is neither an Error nor a
// lack of resources is kInternal.
[[nodiscard]] Error caught_error();

}  // namespace edvo
