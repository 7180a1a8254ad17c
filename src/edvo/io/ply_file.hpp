// SPDX-License-Identifier: MIT
// Point clouds and meshes as PLY, which MeshLab, CloudCompare and Open3D read.
#pragma once

#include "edvo/core/mesh.hpp"

#include <filesystem>
#include <span>

namespace edvo {

// Binary, little endian: x, y, z as float [m], red, green, blue as uchar. Throws
// Error(kOutput) and leaves an existing file as it was if it cannot be written.
void write_ply(const std::filesystem::path& file, std::span<const ColoredPoint> points);

// The same with faces: three vertices each, as int.
void write_mesh(const std::filesystem::path& file, const Mesh& mesh);

}  // namespace edvo
