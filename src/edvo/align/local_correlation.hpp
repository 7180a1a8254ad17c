// SPDX-License-Identifier: MIT
// How alike two images are in each part of them where a motion brings them together.
#pragma once

#include "edvo/align/align.hpp"

namespace edvo {

// Correlation of the reference's points' intensities with what the frame has there, cell by cell of
// the reference's image, and averaged over the cells [-1..1]. Unlike residuals it does not depend
// on the images' contrast, and unlike the correlation of all points at once it does not tell a
// bright part from a dark one, which any motion brings together. 1 where hardly any cell has
// texture.
[[nodiscard]] double local_correlation(const Reference& reference, const Frame& frame, int level,
                                       const Alignment& alignment, AlignScratch& scratch);

}  // namespace edvo
