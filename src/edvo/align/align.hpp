// SPDX-License-Identifier: MIT
// Direct alignment of a frame to a keyframe, coarse to fine.
#pragma once

#include "edvo/align/photometric.hpp"
#include "edvo/align/point_to_plane.hpp"
#include "edvo/align/reference.hpp"
#include "edvo/align/robust.hpp"
#include "edvo/core/inplace_vector.hpp"
#include "edvo/core/se3.hpp"

#include <concepts>

namespace edvo {

// visit_fields lists the options of the program; the other fields are constants that tests and the
// coarse alignment vary (docs/experiments/options.md).
struct AlignOptions {
  int finest_level = 0;
  int coarsest_level = 3;
  Loss loss = Loss::kStudent;
  double loss_parameter = 2;
  double min_sigma = 2.0;                                                   // [grey levels]
  double gradient_weight_scale = ReferenceOptions{}.gradient_weight_scale;  // [grey levels / px]
  int max_iterations = 30;
  double step_tolerance = 0.05;  // [px]
  bool brightness = true;
  bool rolling_shutter = true;
  double depth_weight = 0.2;
  double depth_noise = 0.003;    // [1 / m]
  int surface_cell = 14;         // [px]
  double min_overlap = 0.3;      // [0..1]
  double min_inliers = 0.4;      // [0..1]
  double min_correlation = 0.4;  // [-1..1]
};

template <typename Self, typename Visitor>
requires std::same_as<std::remove_const_t<Self>, AlignOptions>
void visit_fields(Self& self, Visitor&& visit) {
  visit("finest_level", self.finest_level, Range{0, kMostLevels - 1},
        "last pyramid level used, 0 = full image");
  visit("coarsest_level", self.coarsest_level, Range{0, kMostLevels - 1},
        "first pyramid level used");
  visit("loss", self.loss, Range{},
        "robust loss of the residuals; the paper has huber, 1.345 (Eq. 6)");
  visit("loss_parameter", self.loss_parameter, Range{0.1, 100},
        "theta_H of Eq. 6, Tukey's cut-off or Student's degrees of freedom [sigmas]");
  visit("min_sigma", self.min_sigma, Range{0.01, 255},
        "least sigma of photometric residuals; above it the data decide [grey levels]");
  visit("brightness", self.brightness, Range{}, "estimate gain and bias of each frame");
  visit("rolling_shutter", self.rolling_shutter, Range{},
        "estimate how long the camera takes to read an image row by row, and allow for it");
  visit("depth_weight", self.depth_weight, Range{0, 1e3},
        "weight of the point-to-plane residuals of depth; 0 = off");
  visit("depth_noise", self.depth_noise, Range{1e-6, 1},
        "sigma of measured inverse depth, less where the residuals are smaller [1 / m]");
}

// One pyramid level of one frame's alignment.
struct LevelStats {
  int level = 0;       // 0 = full resolution
  int iterations = 0;  // linearizations
  int points = 0;      // residuals at this level
  double cost = 0;     // mean robust cost at the end [residual sigmas squared]
  bool converged = false;
};

using LevelList = InplaceVector<LevelStats, kMostLevels>;

enum class AlignStatus { kTracked, kLost };

struct AlignResult {
  Alignment alignment;
  Matrix6d information = Matrix6d::Zero();  // of xi in cur_from_ref * exp(xi)
  AlignStatus status = AlignStatus::kLost;
  double overlap = 0;       // [0..1]
  double inlier_ratio = 0;  // [0..1]
  double correlation = 0;   // of fitting points' intensities in both images [-1..1]
  double sigma = 0;         // of the residuals at the finest level [grey levels]
  LevelList levels;         // coarse to fine
};

// Where the camera's centre is expected, in the reference camera [m].
struct PositionPrior {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double sigma = 0;  // [m], 0 = nothing is expected
};

// Room to work in. Who keeps it from frame to frame tracks without taking memory from the heap;
// what is in it between two calls means nothing.
struct AlignScratch {
  std::vector<float> residuals, other_residuals;
  DepthAssociations associations;
  std::vector<float> surface_errors;
};

[[nodiscard]] AlignResult align(const Reference& reference, const Frame& frame,
                                const Alignment& guess, const AlignOptions& options,
                                AlignScratch& scratch, const PositionPrior& prior = {});

// The same with room of its own.
[[nodiscard]] AlignResult align(const Reference& reference, const Frame& frame,
                                const Alignment& guess, const AlignOptions& options);

// Mean robust cost of a guess at the coarsest level: to choose between guesses.
[[nodiscard]] double coarse_cost(const Reference& reference, const Frame& frame,
                                 const Alignment& guess, const AlignOptions& options,
                                 AlignScratch& scratch);

// How far apart two poses cur_from_ref see the points of a level, on average [widths of the image].
[[nodiscard]] double mean_flow(const Reference& reference, int level, const SE3& a, const SE3& b);

}  // namespace edvo
