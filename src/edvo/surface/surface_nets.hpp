// SPDX-License-Identifier: MIT
// The surface where a volume's distances change their sign, as triangles.
#pragma once

#include "edvo/core/mesh.hpp"
#include "edvo/surface/tsdf_volume.hpp"

namespace edvo {

struct MeshOptions {
  int min_part = 100;  // triangles of a connected part; smaller ones float in the air mostly
};

// Surface nets (Gibson 1998): a vertex in each cell of eight voxels that the surface crosses, in
// the mean of the crossings of the cell's edges, and two triangles for each edge that it crosses.
// Cells with a voxel that nothing was measured of have no surface. In the order of the blocks'
// corners.
[[nodiscard]] Mesh extract_mesh(const TsdfVolume& volume, const MeshOptions& options = {});

}  // namespace edvo
