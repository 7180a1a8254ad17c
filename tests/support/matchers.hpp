// SPDX-License-Identifier: MIT
// Matchers and small worlds shared by the tests.
#pragma once

#include "edvo/core/se3.hpp"

#include <gmock/gmock.h>

namespace edvo::test {

// Distance of two poses: translation [m] and rotation [rad], each below tolerance.
MATCHER_P2(NearPose, expected, tolerance, "") {
  const SE3 error = inverse(expected) * arg;
  *result_listener << "translation off by " << error.translation.norm() << " m, rotation by "
                   << rotation_angle(error) << " rad";
  return error.translation.norm() < tolerance && rotation_angle(error) < tolerance;
}

}  // namespace edvo::test
