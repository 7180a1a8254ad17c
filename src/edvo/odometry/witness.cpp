// SPDX-License-Identifier: MIT
#include "edvo/odometry/witness.hpp"

#include <algorithm>

// Numbers are those of docs/adr/0012: chosen with benchmarks/moving.py on seeds 1 to 12, and so
// that none of the 2159 frames of fr1/xyz, desk, rpy and ICL-NUIM kt3 is lost.

namespace edvo {
namespace {

// Shares of the witness's points or of its image [0..1].
constexpr double kLeastInView = 0.35;     // to be asked
constexpr double kLeastExplained = 0.35;  // by the camera's motion
constexpr double kStillFresh = 0.8;       // of what was explained at first: it need not change
constexpr double kStillInView = 0.9;      // the same, of its points
constexpr double kContradicted = 0.6;     // of what was explained at first, and of the present one
constexpr double kLeastBehind = 0.25;     // of its cells in view that are not hidden, to tell
constexpr double kClearlyMore = 0.1;      // of image and depth together, by another motion
constexpr double kMostGrown = 2.5;  // times the usual sigma: no motion that explains the witness

// Shares of the witness's flat pieces with depth [0..1], and how much nearer and farther are.
constexpr double kSomeInFront = 0.15, kMuchInFront = 0.3;
constexpr double kFewFarther = 0.5;  // of those that are nearer
constexpr int kLeastDepths = 30;

// Between two poses [widths of the image]: not the same motion; where something is in front, and
// elsewhere.
constexpr double kApartBehind = 0.003, kApart = 0.008;
// More off the predicted one with nothing in front: rather a pattern that repeats.
constexpr double kMostSudden = 0.05;

constexpr int kLevels = 3;  // that a frame is aligned to the witness at

// The alignment a -> c, from a -> b and b -> c.
Alignment chained(const Alignment& first, const Alignment& second) {
  return {.cur_from_ref = second.cur_from_ref * first.cur_from_ref,
          .gain = second.gain * first.gain,
          .bias = second.gain * first.bias + second.bias};
}

double in_front(const MotionSupport& support) {
  const bool is_all = support.farther < kFewFarther * support.nearer;
  return support.depths >= kLeastDepths && is_all ? support.nearer : 0;
}

// What was found of the witness, of the present keyframe.
AlignResult to_present(AlignResult found, const Alignment& present) {
  const SE3 witness_from_present = inverse(present.cur_from_ref);
  const Matrix6d to_witness = adjoint(witness_from_present);
  Alignment& alignment = found.alignment;
  alignment.cur_from_ref = alignment.cur_from_ref * witness_from_present;
  alignment.gain /= present.gain;
  alignment.bias -= alignment.gain * present.bias;
  found.information = to_witness.transpose() * found.information * to_witness;
  return found;
}

}  // namespace

Testimony question(const Witness& witness, const AlignResult& result, double explained,
                   const MotionEvidence& evidence, const AlignOptions& options,
                   AlignScratch& scratch) {
  const auto support_of = [&](const Alignment& alignment, double sigma) {
    return support_within(largest_fitting(sigma, evidence.state.usual_sigma), witness.reference,
                          evidence.frame, alignment, options, scratch);
  };
  const Alignment claimed = chained(witness.alignment, result.alignment);
  const MotionSupport of_claimed = support_of(claimed, result.sigma);
  if (of_claimed.in_view < kLeastInView) return {};

  AlignOptions fine = options;
  fine.coarsest_level = std::min(options.coarsest_level, options.finest_level + kLevels - 1);
  Alignment predicted = claimed;
  predicted.cur_from_ref = evidence.predicted * witness.alignment.cur_from_ref;
  AlignResult other;
  MotionSupport of_other;
  for (const Alignment& start : {claimed, predicted}) {
    const AlignResult found = align(witness.reference, evidence.frame, start, fine, scratch);
    if (found.status != AlignStatus::kTracked) continue;
    const MotionSupport of_found = support_of(found.alignment, found.sigma);
    if (other.status == AlignStatus::kTracked &&
        of_found.intensity + of_found.depth <= of_other.intensity + of_other.depth)
      continue;
    other = found;
    of_other = of_found;
  }
  Testimony said = {.in_front = in_front(of_claimed)};
  const auto apart = [&](const Reference& reference, const Alignment& a, const SE3& b) {
    return mean_flow(reference, options.finest_level, a.cur_from_ref, b);
  };
  const AlignResult corrected = to_present(other, witness.alignment);
  if (other.status == AlignStatus::kTracked && of_other.intensity >= kLeastExplained &&
      other.sigma < kMostGrown * sigma_baseline(evidence.state) &&
      of_other.intensity + of_other.depth >
          of_claimed.intensity + of_claimed.depth + kClearlyMore &&
      apart(witness.reference, claimed, other.alignment.cur_from_ref) >
          (said.in_front > kSomeInFront ? kApartBehind : kApart) &&
      (said.in_front > kSomeInFront ||
       apart(evidence.reference, corrected.alignment, evidence.predicted) <
           kMostSudden + apart(evidence.reference, result.alignment, evidence.predicted)))
    said.correction = corrected;
  else
    said.contradicts = of_claimed.cells_behind < kLeastBehind * of_claimed.cells
                           ? said.in_front > kMuchInFront
                           : said.in_front > kSomeInFront &&
                                 of_claimed.intensity_behind <
                                     kContradicted * std::min(witness.explained, explained);
  return said;
}

bool is_hidden(const Reference& reference, const Frame& frame, const SE3& cur_from_ref,
               const AlignOptions& options, AlignScratch& scratch) {
  return in_front(motion_support(reference, frame, options.finest_level,
                                 {.cur_from_ref = cur_from_ref}, {}, scratch)) > kMuchInFront;
}

void hand_over(std::optional<Witness>& witness, const Reference& present, const Frame& frame,
               const TrackingState& state, const AlignOptions& options, AlignScratch& scratch) {
  const auto support_now = [&] {
    return support_within(largest_fitting(state.usual_sigma, state.usual_sigma), witness->reference,
                          frame, witness->alignment, options, scratch);
  };
  if (witness) {
    witness->alignment = chained(witness->alignment, state.alignment);
    const MotionSupport now = support_now();
    if (expects_one_motion(state)
            ? now.in_view >= kStillInView && now.intensity > kStillFresh * witness->explained
            : now.in_view >= kLeastInView)
      return;
  }
  if (!witness) witness.emplace();
  witness->reference = present;  // into the memory of the one before
  witness->alignment = state.alignment;
  witness->explained = support_now().intensity;
}

}  // namespace edvo
