// SPDX-License-Identifier: MIT
// A surface of triangles.
#pragma once

#include "edvo/core/colored_point.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace edvo {

struct Mesh {
  std::vector<ColoredPoint> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // of vertices, anticlockwise from outside
};

}  // namespace edvo
