// SPDX-License-Identifier: MIT
// What a test expects of an edvo::Error.
#pragma once

#include "edvo/core/error.hpp"

#include <gtest/gtest.h>
#include <optional>

namespace edvo::test {

// The error that action throws, or none.
template <typename Action>
std::optional<Error> error_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

// Passes if action throws Error(code) whose message contains each of parts.
template <typename Action>
testing::AssertionResult fails_with(ErrorCode code, std::initializer_list<std::string> parts,
                                    Action&& action) {
  const std::optional<Error> error = error_of(action);
  if (!error) return testing::AssertionFailure() << "no Error thrown";
  const std::string message = error->what();
  if (error->code() != code)
    return testing::AssertionFailure()
           << "code " << static_cast<int>(error->code()) << ": " << message;
  for (const std::string& part : parts)
    if (message.find(part) == std::string::npos)
      return testing::AssertionFailure() << "\"" << part << "\" is not in: " << message;
  return testing::AssertionSuccess() << message;
}

}  // namespace edvo::test
