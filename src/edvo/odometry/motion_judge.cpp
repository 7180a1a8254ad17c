// SPDX-License-Identifier: MIT
#include "edvo/odometry/motion_judge.hpp"

#include <algorithm>

// Numbers are those of docs/adr/0010: chosen on fr1/xyz, desk, rpy and ICL-NUIM kt3, where none of
// 2159 frames may be lost, and on the clips of benchmarks/bad_frames.py.

namespace edvo {
namespace {

// A point fits if its residual is below so many sigmas, the usual or the frame's, whichever is
// less.
constexpr double kFits = 3.0;
constexpr double kLeastSigma = 3.0, kFirstSigma = 5.0;  // [grey levels] the latter if none is usual
constexpr double kMostLimit = 20.0;                     // [grey levels] for a second motion

// Shares of the image's area [0..1]. A good frame explains at least 0.67 and 95 % of them 0.82.
constexpr double kMostlyExplained = 0.85,
                 kMostlyIfSudden = 0.95;  // else a second one is looked for
constexpr double kLeastExplained = 0.6;
constexpr double kLeastInDoubt = 0.7;
constexpr double kCoherent = 0.8;       // of what the first leaves over: a second explains it
constexpr double kCoherentDepth = 0.5;  // the same, of its depth
constexpr double kLeastRest = 0.1;      // left over
constexpr double kSameDepth = 0.9, kOtherDepth = 0.4;

// Something else than the scene fits very well if much does not and residuals are below the usual:
// blur, which explains little as well, raises them.
constexpr double kNarrow = 0.7, kNarrowExplained = 0.72;  // times the usual sigma, share
constexpr double kNotWider = 0.9, kNotWiderExplained = 0.7;

// Between two poses [widths of the image].
constexpr double kSudden = 0.01, kVerySudden = 0.02, kMostSudden = 0.03;
constexpr double kTwoMotions = 0.01;
constexpr double kStill = 0.003;

// A motion is the camera's if the other is so many times as unlikely.
constexpr double kClearly = 1.5, kBeyondDoubt = 2.5;
constexpr double kSuddenWeight = 0.4;  // beside the share that is unexplained

// Depth refutes a motion that is kMostSudden off if hardly any of it fits and some is elsewhere by
// a seventh, or if half of it fits at most and the images correlate little: see docs/adr/0016.
constexpr double kHardlyFits = 0.3, kElsewhere = 0.15;
constexpr double kHalfFits = 0.5, kLittleAlike = 0.55;
constexpr int kTellingDepths = 30;

constexpr std::size_t kLeastPoints = 50;  // for an alignment
constexpr int kLeastDepths = 20, kLeastRestDepths = 9;
constexpr int kLevels = 3;  // that a second motion is aligned at

struct Rest {
  AlignResult alignment;
  double explained = 0;  // [0..1] of the points left over
};

class Judge {
 public:
  Judge(const AlignResult& first, const MotionEvidence& evidence, const AlignOptions& options,
        AlignScratch& scratch)
      : first_(first),
        evidence_(evidence),
        options_(options),
        scratch_(scratch),
        of_first_(support(evidence.reference, first.alignment, limit(first.sigma))),
        surprise_(flow(first.alignment.cur_from_ref, evidence.predicted)) {}

  [[nodiscard]] JudgedMotion judge() const {
    JudgedMotion judged{.verdict = alone(), .explained = of_first_.intensity};
    if (of_first_.intensity > (surprise_ > kSudden ? kMostlyIfSudden : kMostlyExplained))
      return judged;
    const Rest rest = align_rest();
    if (rest.alignment.status != AlignStatus::kTracked) return judged;
    compare(rest.alignment, judged);
    return judged;
  }

 private:
  // The verdict on the first motion where no second one is found.
  [[nodiscard]] MotionVerdict alone() const {
    if (evidence_.is_at_rest) return MotionVerdict::kOneMotion;
    const double usual = evidence_.state.usual_sigma;
    const double width = usual > 0 ? first_.sigma / usual : 1;
    const double explained = of_first_.intensity;
    const bool fits_something_else = (width < kNarrow && explained < kNarrowExplained) ||
                                     (width < kNotWider && explained < kNotWiderExplained);
    const bool stands_still = flow(first_.alignment.cur_from_ref, SE3{}) < kStill;
    const bool depth_moves = explained < kMostlyExplained && of_first_.depths >= kLeastDepths &&
                             of_first_.depth < kOtherDepth;
    const int undecided = evidence_.undecided_frames;
    const bool in_doubt = evidence_.state.doubtful_frames > 0 || undecided > 0;
    const bool jumps = surprise_ > kVerySudden * (1 + undecided) ||
                       (surprise_ > kSudden && explained < kLeastInDoubt);
    if (fits_something_else || (stands_still && depth_moves) || (in_doubt && jumps))
      return MotionVerdict::kUndecided;
    const bool as_expected = surprise_ < kSudden && of_first_.depth > kSameDepth;
    if (explained < kLeastExplained && !as_expected)
      return undecided > 0 ? MotionVerdict::kUndecided : MotionVerdict::kUnexplained;
    return MotionVerdict::kOneMotion;
  }

  // The motion that explains most of the points that the first leaves over.
  [[nodiscard]] Rest align_rest() const {
    const auto cells = std::ranges::count(of_first_.states, CellState::kUnexplained);
    if (static_cast<double>(cells) < kLeastRest * of_first_.cells) return {};
    const Reference rest =
        points_in(evidence_.reference, of_first_.states, CellState::kUnexplained);
    if (rest.levels[static_cast<std::size_t>(options_.finest_level)].count < kLeastPoints)
      return {};
    AlignOptions options = options_;
    options.coarsest_level = std::min(options.coarsest_level, options.finest_level + kLevels - 1);
    const SE3& last = evidence_.state.alignment.cur_from_ref;
    InplaceVector<SE3, kMostCandidates + 2> starts;
    for (const SE3& motion : evidence_.candidates) starts.push_back(motion * last);
    starts.push_back(last);
    starts.push_back(SE3{});  // on the lens
    Rest best;
    for (const SE3& start : starts) {
      Alignment guess = first_.alignment;
      guess.cur_from_ref = start;
      const AlignResult other = align(rest, evidence_.frame, guess, options, scratch_);
      if (other.status != AlignStatus::kTracked) continue;
      const MotionSupport of_rest =
          support(rest, other.alignment, std::min(kMostLimit, limit(kFirstSigma)));
      const bool is_rigid =
          of_rest.depths < kLeastRestDepths || of_rest.depth >= kCoherentDepth || is_on_lens(other);
      if (is_rigid && of_rest.intensity > best.explained)
        best = {.alignment = other, .explained = of_rest.intensity};
    }
    if (best.explained < kCoherent ||
        flow(first_.alignment.cur_from_ref, best.alignment.alignment.cur_from_ref) < kTwoMotions)
      return {};
    return best;
  }

  void compare(const AlignResult& second, JudgedMotion& judged) const {
    const MotionSupport of_second =
        support(evidence_.reference, second.alignment, limit(second.sigma));
    const double surprise = flow(second.alignment.cur_from_ref, evidence_.predicted);
    const double a = unlikeliness(of_first_, surprise_), b = unlikeliness(of_second, surprise);
    const bool is_first = evidence_.is_at_rest || b > required(surprise_) * a;
    const bool is_second = a > required(surprise) * b;
    judged.verdict = is_first    ? MotionVerdict::kFirst
                     : is_second ? MotionVerdict::kSecond
                                 : MotionVerdict::kUndecided;
    if (judged.verdict == MotionVerdict::kUndecided) return;
    const AlignResult& other = is_first ? second : first_;
    judged.camera = is_first ? first_ : second;
    judged.cells = is_first ? of_first_.states : of_second.states;
    judged.others =
        moved_cells(points(), judged.cells, CellState::kUnexplained, other.alignment.cur_from_ref);
    judged.is_clear = evidence_.is_at_rest || std::max(a, b) > kBeyondDoubt * std::min(a, b);
  }

  // Shares of the image and of its depth that a motion leaves unexplained, and how sudden it is.
  static double unlikeliness(const MotionSupport& support, double surprise) {
    return (1 - support.intensity) + (1 - support.depth) +
           kSuddenWeight * std::min(1.0, surprise / kMostSudden);
  }

  static double required(double surprise) {
    return surprise > kVerySudden ? kBeyondDoubt : kClearly;
  }

  [[nodiscard]] bool is_on_lens(const AlignResult& motion) const {
    return flow(motion.alignment.cur_from_ref, SE3{}) < kStill;
  }

  // Largest residual that fits. [grey levels]
  [[nodiscard]] double limit(double sigma) const {
    return largest_fitting(sigma, evidence_.state.usual_sigma);
  }

  [[nodiscard]] MotionSupport support(const Reference& reference, const Alignment& alignment,
                                      double intensity_limit) const {
    return support_within(intensity_limit, reference, evidence_.frame, alignment, options_,
                          scratch_);
  }

  [[nodiscard]] double flow(const SE3& a, const SE3& b) const {
    return mean_flow(evidence_.reference, options_.finest_level, a, b);
  }

  [[nodiscard]] const ReferenceLevel& points() const {
    return evidence_.reference.levels[static_cast<std::size_t>(options_.finest_level)];
  }

  const AlignResult& first_;
  const MotionEvidence& evidence_;
  const AlignOptions& options_;
  AlignScratch& scratch_;
  MotionSupport of_first_;
  double surprise_;  // [widths of the image] of the first, off the constant velocity
};

}  // namespace

double largest_fitting(double sigma, double usual_sigma) {
  return kFits * std::max(kLeastSigma, usual_sigma > 0 ? std::min(sigma, usual_sigma) : sigma);
}

MotionSupport support_within(double largest, const Reference& reference, const Frame& frame,
                             const Alignment& alignment, const AlignOptions& options,
                             AlignScratch& scratch) {
  return motion_support(reference, frame, options.finest_level, alignment,
                        {.intensity = static_cast<float>(largest),
                         .depth = static_cast<float>(kFits * options.depth_noise)},
                        scratch);
}

bool is_refuted_by_depth(const AlignResult& result, const Reference& reference, const Frame& frame,
                         const SE3& predicted, const AlignOptions& options, AlignScratch& scratch) {
  const SE3& motion = result.alignment.cur_from_ref;
  if (mean_flow(reference, options.finest_level, motion, predicted) < kMostSudden) return false;
  const MotionSupport support =
      support_within(kMostLimit, reference, frame, result.alignment, options, scratch);
  if (support.depths < kTellingDepths) return false;
  return (support.depth < kHardlyFits && support.nearer + support.farther > kElsewhere) ||
         (support.depth < kHalfFits && result.correlation < kLittleAlike);
}

JudgedMotion judge_motion(const AlignResult& first, const MotionEvidence& evidence,
                          const AlignOptions& options, AlignScratch& scratch) {
  return Judge(first, evidence, options, scratch).judge();
}

}  // namespace edvo
