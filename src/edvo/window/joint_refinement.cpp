// SPDX-License-Identifier: MIT
#include "edvo/window/joint_refinement.hpp"

#include "edvo/core/parallel.hpp"
#include "edvo/window/block_cholesky.hpp"
#include "edvo/window/keyframe_unknowns.hpp"
#include "edvo/window/pair_model.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;
constexpr double kDamping = 1e-4;
constexpr double kStale = 0.1;  // [px] that points have moved by for a pair to be linearized anew
constexpr int kNextInTime = 5;  // keyframes to each side that are always neighbours
constexpr int kApart = 3;       // keyframes between two other neighbours
constexpr double kView = 0.3;   // [0..1] of the points that both must see of each other
constexpr int kAtOnce = 32;     // hosts whose systems are in memory

using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A host's points seen in all of its targets. Unknowns: the host's, then each target's.
struct HostSystem {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  RowMatrix coupling;  // (points) x unknowns
  Eigen::VectorXf depth_gradient, depth_curvature;
  double cost = 0;
};

// The same with the points' inverse depths at their best.
struct ReducedSystem {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  double cost = 0;
};

// Of inverse depths by what was measured; returns the cost.
double add_priors(const std::vector<WindowPoint>& points, Eigen::VectorXf& gradient,
                  Eigen::VectorXf& curvature) {
  double cost = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const WindowPoint& point = points[i];
    const double error = point.inverse_depth - point.measured;
    gradient[static_cast<Eigen::Index>(i)] = static_cast<float>(point.weight * error);
    curvature[static_cast<Eigen::Index>(i)] = static_cast<float>(point.weight);
    cost += 0.5 * point.weight * error * error;
  }
  return cost;
}

// What a pair adds to the systems of the host's inverse depths after a step of both keyframes.
void add_moved(const PairModel& model, const BlockVector& host_step, const BlockVector& target_step,
               Eigen::VectorXf& gradient, Eigen::VectorXf& curvature) {
  const Eigen::Map<const Eigen::Matrix<float, kN, 1>> b(kFromTarget.data());
  const Eigen::Matrix<float, kN, 1> step =
      (from_host(model.geometry) * host_step + b.cast<double>().cwiseProduct(target_step))
          .cast<float>();
  const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, kN, Eigen::RowMajor>> coupling(
      model.coupling.data(), gradient.size(), kN);
  gradient += coupling * step;
  for (std::size_t i = 0; i < model.point_normals.size(); ++i) {
    gradient[static_cast<Eigen::Index>(i)] += model.point_normals[i].gradient;
    curvature[static_cast<Eigen::Index>(i)] += model.point_normals[i].curvature;
  }
}

void add_model(const PairModel& model, int target, HostSystem& s) {
  const BlockMatrix A = from_host(model.geometry);
  const Eigen::Map<const Eigen::Matrix<float, kN, 1>> B(kFromTarget.data());
  const BlockVector b = B.cast<double>();
  const BlockMatrix H =
      Eigen::Map<const Eigen::Matrix<float, kN, kN, Eigen::RowMajor>>(model.sums.hessian.data())
          .cast<double>();
  const BlockVector g =
      Eigen::Map<const Eigen::Matrix<float, kN, 1>>(model.sums.gradient.data()).cast<double>();
  const int t = kN * (1 + target);
  const BlockMatrix cross = A.transpose() * H * b.asDiagonal();
  s.hessian.topLeftCorner<kN, kN>() += A.transpose() * H * A;
  s.hessian.block<kN, kN>(t, t) += b.asDiagonal() * H * b.asDiagonal();
  s.hessian.block<kN, kN>(0, t) += cross;
  s.hessian.block<kN, kN>(t, 0) += cross.transpose();
  s.gradient.head<kN>() += A.transpose() * g;
  s.gradient.segment<kN>(t) += b.asDiagonal() * g;
  s.cost += model.cost;
  const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, kN, Eigen::RowMajor>> coupling(
      model.coupling.data(), s.coupling.rows(), kN);
  s.coupling.leftCols<kN>() += coupling * A.cast<float>();
  s.coupling.middleCols<kN>(t) = coupling * B.asDiagonal();
  for (std::size_t i = 0; i < model.point_normals.size(); ++i) {
    s.depth_gradient[static_cast<Eigen::Index>(i)] += model.point_normals[i].gradient;
    s.depth_curvature[static_cast<Eigen::Index>(i)] += model.point_normals[i].curvature;
  }
}

HostSystem host_system(const WindowKeyframe& host, const std::vector<PairModel>& models) {
  const auto points = static_cast<Eigen::Index>(host.points.size());
  const int n = kN * (1 + static_cast<int>(models.size()));
  HostSystem s{.hessian = Eigen::MatrixXd::Zero(n, n),
               .gradient = Eigen::VectorXd::Zero(n),
               .coupling = RowMatrix::Zero(points, n),
               .depth_gradient = Eigen::VectorXf::Zero(points),
               .depth_curvature = Eigen::VectorXf::Zero(points)};
  s.cost = add_priors(host.points, s.depth_gradient, s.depth_curvature);
  brightness_prior(host.gain, host.bias).add_to(s, 6);
  for (std::size_t k = 0; k < models.size(); ++k) add_model(models[k], static_cast<int>(k), s);
  return s;
}

ReducedSystem reduce(const HostSystem& s) {
  const Eigen::VectorXf scale = s.depth_curvature.cwiseInverse().cwiseSqrt();
  const RowMatrix scaled = scale.asDiagonal() * s.coupling;
  const Eigen::VectorXf depths = scale.cwiseProduct(s.depth_gradient);
  Eigen::MatrixXf by_depths = Eigen::MatrixXf::Zero(s.hessian.rows(), s.hessian.cols());
  by_depths.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
  by_depths.triangularView<Eigen::StrictlyUpper>() = by_depths.transpose();
  return {.hessian = s.hessian - by_depths.cast<double>(),
          .gradient = s.gradient - (scaled.transpose() * depths).cast<double>(),
          .cost = s.cost};
}

class JointProblem {
 public:
  JointProblem(std::vector<WindowKeyframe>& keyframes, const std::vector<std::vector<int>>& targets,
               const Camera& camera, const WindowOptions& window, int threads)
      : keyframes_(keyframes),
        targets_(targets),
        constants_(pair_constants(camera, window)),
        threads_(threads),
        models_(keyframes.size()) {
    for (std::size_t h = 0; h < keyframes.size(); ++h) models_[h].resize(targets[h].size());
    system_.emplace(static_cast<int>(keyframes.size()) - 1, pattern());
  }

  // Makes the system of the present state; returns the cost.
  double linearize() {
    system_->set_zero();
    gradient_ = Eigen::VectorXd::Zero(kN * (static_cast<int>(keyframes_.size()) - 1));
    double cost = 0;
    const int count = static_cast<int>(keyframes_.size());
    std::vector<ReducedSystem> systems(kAtOnce);
    for (int first = 0; first < count; first += kAtOnce) {
      const int now = std::min(kAtOnce, count - first);
      for_each_index(now, threads_, [&](int i) {
        const auto h = static_cast<std::size_t>(first + i);
        for (std::size_t k = 0; k < targets_[h].size(); ++k)
          update_pair(constants_, keyframes_[h],
                      keyframes_[static_cast<std::size_t>(targets_[h][k])], kStale, models_[h][k]);
        systems[static_cast<std::size_t>(i)] = reduce(host_system(keyframes_[h], models_[h]));
      });
      for (int i = 0; i < now; ++i) {
        add(first + i, systems[static_cast<std::size_t>(i)]);
        cost += systems[static_cast<std::size_t>(i)].cost;
      }
    }
    return cost;
  }

  // Goes to the lowest point of that system; false, and nothing changes, if it has none.
  bool step() {
    if (!system_->factorize(1 + kDamping)) return false;
    const Eigen::VectorXd step = system_->solve(-gradient_);
    if (!step.allFinite()) return false;
    for_each_index(static_cast<int>(keyframes_.size()), threads_,
                   [&](int h) { move_points(h, step); });
    for (std::size_t k = 1; k < keyframes_.size(); ++k)
      move_keyframe(step.segment<kN>(kN * row_of(static_cast<int>(k))), keyframes_[k]);
    return true;
  }

 private:
  // Of blocks; the first keyframe has none.
  static int row_of(int keyframe) { return keyframe - 1; }

  [[nodiscard]] std::vector<int> rows_of(int host) const {
    std::vector<int> all = {row_of(host)};
    for (const int t : targets_[static_cast<std::size_t>(host)]) all.push_back(row_of(t));
    return all;
  }

  // All blocks below the diagonal that hosts add to.
  [[nodiscard]] std::vector<std::pair<int, int>> pattern() const {
    std::vector<std::pair<int, int>> blocks;
    for (int h = 0; h < static_cast<int>(keyframes_.size()); ++h)
      for (const int a : rows_of(h))
        for (const int b : rows_of(h))
          if (b >= 0 && a > b) blocks.emplace_back(a, b);
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    return blocks;
  }

  void add(int host, const ReducedSystem& system) {
    const std::vector<int> all = rows_of(host);
    for (int j = 0; j < static_cast<int>(all.size()); ++j) {
      const int b = all[static_cast<std::size_t>(j)];
      if (b < 0) continue;
      gradient_.segment<kN>(kN * b) += system.gradient.segment<kN>(kN * j);
      for (int i = 0; i < static_cast<int>(all.size()); ++i)
        if (const int a = all[static_cast<std::size_t>(i)]; a >= b)
          system_->add(a, b, system.hessian.block<kN, kN>(kN * i, kN * j));
    }
  }

  // The inverse depths of a host's points, as a step of the keyframes leaves them best.
  void move_points(int host, const Eigen::VectorXd& step) {
    const auto h = static_cast<std::size_t>(host);
    const auto step_of = [&](int keyframe) -> BlockVector {
      if (row_of(keyframe) < 0) return BlockVector::Zero();
      return step.segment<kN>(kN * row_of(keyframe));
    };
    std::vector<WindowPoint>& points = keyframes_[h].points;
    Eigen::VectorXf gradient(points.size()), curvature(points.size());
    add_priors(points, gradient, curvature);
    for (std::size_t k = 0; k < models_[h].size(); ++k)
      add_moved(models_[h][k], step_of(host), step_of(targets_[h][k]), gradient, curvature);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      (void)move_point(static_cast<double>(-gradient[at] / curvature[at]), points[i]);
    }
  }

  std::vector<WindowKeyframe>& keyframes_;
  const std::vector<std::vector<int>>& targets_;
  PairConstants constants_;
  int threads_;
  std::vector<std::vector<PairModel>> models_;  // of each host and its targets
  std::optional<BlockCholesky> system_;
  Eigen::VectorXd gradient_;
};

double view_in_common(const WindowKeyframe& a, const WindowKeyframe& b, const Camera& camera) {
  const double view = shared_view(a, b, camera);
  return view < kView ? view : std::min(view, shared_view(b, a, camera));
}

}  // namespace

std::vector<std::vector<int>> keyframes_in_view(const std::vector<WindowKeyframe>& keyframes,
                                                const Camera& camera, int count) {
  const int all = static_cast<int>(keyframes.size());
  std::vector<std::vector<int>> chosen(keyframes.size());
  for (int h = 0; h < all; ++h) {
    std::vector<int>& mine = chosen[static_cast<std::size_t>(h)];
    std::vector<std::pair<double, int>> views;  // negated, so that sorting puts the best first
    for (int t = 0; t < all; ++t) {
      if (t == h) continue;
      if (std::abs(t - h) <= kNextInTime) {
        mine.push_back(t);
        continue;
      }
      const double view = view_in_common(keyframes[static_cast<std::size_t>(h)],
                                         keyframes[static_cast<std::size_t>(t)], camera);
      if (view >= kView) views.emplace_back(-view, t);
    }
    std::sort(views.begin(), views.end());
    for (const auto& view : views) {
      const int t = view.second;
      if (static_cast<int>(mine.size()) >= count) break;
      if (std::none_of(mine.begin(), mine.end(), [t](int c) { return std::abs(c - t) < kApart; }))
        mine.push_back(t);
    }
    std::sort(mine.begin(), mine.end());
  }
  return chosen;
}

JointSummary refine_jointly(std::vector<WindowKeyframe>& keyframes,
                            const std::vector<std::vector<int>>& targets, const Camera& camera,
                            const WindowOptions& window, const JointOptions& options) {
  if (keyframes.size() < 2) return {};
  JointProblem problem(keyframes, targets, camera, window, options.threads);
  JointSummary summary;
  summary.first_cost = summary.cost = problem.linearize();
  for (summary.iterations = 1; summary.iterations < options.iterations; ++summary.iterations) {
    const Estimates before = estimates_of(keyframes);
    if (!problem.step()) break;
    const double gained = summary.cost - problem.linearize();
    if (!(gained > 0)) {  // nor where it is not a number
      restore(before, keyframes);
      break;
    }
    summary.cost -= gained;
    if (gained < options.tolerance * summary.cost) break;
  }
  return summary;
}

}  // namespace edvo
