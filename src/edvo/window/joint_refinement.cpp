// SPDX-License-Identifier: MIT
#include "edvo/window/joint_refinement.hpp"

#include "edvo/core/parallel.hpp"
#include "edvo/window/keyframe_unknowns.hpp"
#include "edvo/window/pair_model.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <utility>

namespace edvo {
namespace {

constexpr int kN = kKeyframeUnknowns;
constexpr double kDamping = 1e-4;
constexpr double kStale = 0.1;   // [px] that points have moved by for a pair to be linearized anew
constexpr int kNextInTime = 3;   // keyframes to each side that are always neighbours
constexpr int kApart = 3;        // keyframes between two other neighbours
constexpr double kView = 0.3;    // [0..1] of the points that both must see of each other
constexpr double kTurned = 0.5;  // cosine between directions of view, below: nothing in common
constexpr int kAtOnce = 32;      // hosts whose systems are in memory

using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using SparseMatrix = Eigen::SparseMatrix<double>;

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

void add_priors(const WindowKeyframe& host, HostSystem& s) {
  for (std::size_t i = 0; i < host.points.size(); ++i) {
    const WindowPoint& point = host.points[i];
    const double error = point.inverse_depth - point.measured;
    s.depth_gradient[static_cast<Eigen::Index>(i)] = static_cast<float>(point.weight * error);
    s.depth_curvature[static_cast<Eigen::Index>(i)] = static_cast<float>(point.weight);
    s.cost += 0.5 * point.weight * error * error;
  }
  brightness_prior(host.gain, host.bias).add_to(s, 6);
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
  add_priors(host, s);
  for (std::size_t k = 0; k < models.size(); ++k) add_model(models[k], static_cast<int>(k), s);
  return s;
}

ReducedSystem reduce(const HostSystem& s) {
  const RowMatrix scaled = s.depth_curvature.cwiseInverse().asDiagonal() * s.coupling;
  return {.hessian = s.hessian - (s.coupling.transpose() * scaled).cast<double>(),
          .gradient = s.gradient - (scaled.transpose() * s.depth_gradient).cast<double>(),
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
    unknowns_ = kN * (static_cast<int>(keyframes.size()) - 1);
    make_pattern();
  }

  // Makes the system of the present state; returns the cost.
  double linearize() {
    std::fill_n(hessian_.valuePtr(), hessian_.nonZeros(), 0.0);
    gradient_ = Eigen::VectorXd::Zero(unknowns_);
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
    for (int i = 0; i < unknowns_; ++i) hessian_.coeffRef(i, i) *= 1 + kDamping;
    if (!std::exchange(analyzed_, true)) factor_.analyzePattern(hessian_);
    factor_.factorize(hessian_);
    if (factor_.info() != Eigen::Success) return false;
    const Eigen::VectorXd step = factor_.solve(-gradient_);
    if (!step.allFinite()) return false;
    for_each_index(static_cast<int>(keyframes_.size()), threads_,
                   [&](int h) { move_points(h, step); });
    for (std::size_t k = 1; k < keyframes_.size(); ++k)
      move_keyframe(step.segment<kN>(column(static_cast<int>(k))), keyframes_[k]);
    return true;
  }

 private:
  // The first keyframe has none.
  static int column(int keyframe) { return kN * (keyframe - 1); }

  [[nodiscard]] std::vector<int> columns(int host) const {
    std::vector<int> all = {column(host)};
    for (const int t : targets_[static_cast<std::size_t>(host)]) all.push_back(column(t));
    return all;
  }

  // All blocks on and below the diagonal that hosts add to.
  void make_pattern() {
    std::vector<std::pair<int, int>> blocks;
    for (int h = 0; h < static_cast<int>(keyframes_.size()); ++h)
      for (const int a : columns(h))
        for (const int b : columns(h))
          if (b >= 0 && a >= b) blocks.emplace_back(b, a);
    std::sort(blocks.begin(), blocks.end());
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(blocks.size() * kN * kN);
    for (const auto& [b, a] : blocks)
      for (int c = 0; c < kN; ++c)
        for (int r = 0; r < kN; ++r) entries.emplace_back(a + r, b + c, 0.0);
    hessian_.resize(unknowns_, unknowns_);
    hessian_.setFromTriplets(entries.begin(), entries.end());
  }

  void add(int host, const ReducedSystem& system) {
    const std::vector<int> all = columns(host);
    for (int j = 0; j < static_cast<int>(all.size()); ++j) {
      const int b = all[static_cast<std::size_t>(j)];
      if (b < 0) continue;
      gradient_.segment<kN>(b) += system.gradient.segment<kN>(kN * j);
      for (int i = 0; i < static_cast<int>(all.size()); ++i)
        if (all[static_cast<std::size_t>(i)] >= b)
          add_block(all[static_cast<std::size_t>(i)], b,
                    system.hessian.block<kN, kN>(kN * i, kN * j));
    }
  }

  void add_block(int row, int first_column, const BlockMatrix& block) {
    for (int c = 0; c < kN; ++c) {
      const int* const begin =
          hessian_.innerIndexPtr() + hessian_.outerIndexPtr()[first_column + c];
      const int* const end =
          hessian_.innerIndexPtr() + hessian_.outerIndexPtr()[first_column + c + 1];
      double* const values =
          hessian_.valuePtr() + (std::lower_bound(begin, end, row) - hessian_.innerIndexPtr());
      for (int r = 0; r < kN; ++r) values[r] += block(r, c);
    }
  }

  // The inverse depths of a host's points, as a step of the keyframes leaves them best.
  void move_points(int host, const Eigen::VectorXd& step) {
    const auto h = static_cast<std::size_t>(host);
    const HostSystem s = host_system(keyframes_[h], models_[h]);
    const std::vector<int> all = columns(host);
    Eigen::VectorXf local = Eigen::VectorXf::Zero(s.gradient.size());
    for (int i = 0; i < static_cast<int>(all.size()); ++i)
      if (const int at = all[static_cast<std::size_t>(i)]; at >= 0)
        local.segment<kN>(kN * i) = step.segment<kN>(at).cast<float>();
    const Eigen::VectorXf depths =
        -(s.depth_gradient + s.coupling * local).cwiseQuotient(s.depth_curvature);
    for (std::size_t i = 0; i < keyframes_[h].points.size(); ++i)
      (void)move_point(static_cast<double>(depths[static_cast<Eigen::Index>(i)]),
                       keyframes_[h].points[i]);
  }

  std::vector<WindowKeyframe>& keyframes_;
  const std::vector<std::vector<int>>& targets_;
  PairConstants constants_;
  int threads_;
  std::vector<std::vector<PairModel>> models_;  // of each host and its targets
  int unknowns_ = 0;
  SparseMatrix hessian_;  // the blocks on and below the diagonal
  Eigen::VectorXd gradient_;
  bool analyzed_ = false;
  Eigen::SimplicialLDLT<SparseMatrix> factor_;
};

double view_in_common(const WindowKeyframe& a, const WindowKeyframe& b, const Camera& camera) {
  const SE3 a_from_b = inverse(a.world_from_key) * b.world_from_key;
  if (a_from_b.rotation.toRotationMatrix()(2, 2) < kTurned) return 0;
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
