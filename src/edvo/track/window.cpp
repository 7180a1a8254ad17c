// SPDX-License-Identifier: MIT
#include "edvo/track/window.hpp"

#include "edvo/track/robust.hpp"
#include "edvo/track/window_system.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edvo {
namespace {

constexpr float kJump = 0.03F;  // difference of neighbouring depths / depth, beyond: not smooth
constexpr double kDamping = 1e-4;
constexpr double kMostRelaxed = 1.9;    // a step twice as long gains nothing on a quadratic cost
constexpr double kWorthAnother = 1e-3;  // of the cost: gained by the last step, worth another round
constexpr float kLeastDepthScale = 0.1F;  // of the depth noise expected

// The depth noise that the newest keyframe and the others show, by what the options say; at most 1:
// poses that are still off make it seem larger.
double depth_scale(const std::vector<WindowKeyframe>& window, const Camera& camera,
                   const WindowOptions& options) {
  const PairConstants constants = pair_constants(camera, options);
  const WindowKeyframe& newest = window.back();
  std::vector<float> errors;
  for (std::size_t k = 0; k + 1 < window.size(); ++k) {
    append_depth_errors(constants, pair_geometry(window[k], newest), window[k].points, newest,
                        errors);
    append_depth_errors(constants, pair_geometry(newest, window[k]), newest.points, window[k],
                        errors);
  }
  return static_cast<double>(std::clamp(mad_sigma(errors), kLeastDepthScale, 1.F));
}

// How far to go along each step (Aitken's delta squared, as Kuettler and Wall 2008 use it).
// Gauss-Newton with the weights of a robust loss takes steps that are too short where few pixels
// match yet; then one step points where the last one did, and the sum of all that would follow is
// known from two. Products are in the metric of the keyframes' Hessian: H step = -gradient.
class Relaxation {
 public:
  double next(const WindowStep& step) {
    const double own = -step.gradient.dot(step.keyframes);
    if (last_.size() > 0) {
      const double cross = -step.gradient.dot(last_);
      factor_ *= (last_own_ - cross) / (last_own_ - 2 * cross + own);
      factor_ = factor_ > 1 ? std::min(factor_, kMostRelaxed) : 1;  // 1 where it is not a number
    }
    last_ = step.keyframes;
    last_own_ = own;
    return factor_;
  }

 private:
  double factor_ = 1, last_own_ = 0;
  Eigen::VectorXd last_;
};

void lengthen(WindowStep& step, double factor) {
  step.keyframes *= factor;
  for (float& depth : step.depths) depth *= static_cast<float>(factor);
}

// The models of a window's pairs, host by host; empty ones where there is none in the memory.
std::vector<PairModel> recall(std::vector<PairModel>& memory,
                              const std::vector<WindowKeyframe>& window) {
  const std::size_t count = window.size();
  const auto index_of = [&](const Stamp& stamp) {
    std::size_t k = 0;
    while (k < count && window[k].stamp != stamp) ++k;
    return k;
  };
  std::vector<PairModel> models(count * count);
  for (PairModel& model : memory) {
    const std::size_t h = index_of(model.host), t = index_of(model.target);
    if (h < count && t < count) models[h * count + t] = std::move(model);
  }
  return models;
}

}  // namespace

WindowKeyframe make_window_keyframe(const Frame& frame, const SE3& world_from_key,
                                    const std::vector<SelectedPixel>& pixels,
                                    const WindowOptions& options) {
  const cv::Mat_<std::uint8_t>& gray = frame.levels.front().gray;
  WindowKeyframe key{.stamp = frame.stamp, .world_from_key = world_from_key};
  key.gray = gray;
  key.inverse_depth = cv::Mat_<float>((gray.rows + 1) / 2, (gray.cols + 1) / 2,
                                      std::numeric_limits<float>::quiet_NaN());
  for (int y = 2; y < gray.rows - 2; y += 2)
    for (int x = 2; x < gray.cols - 2; x += 2) {
      const float z = frame.depth(y, x);
      bool smooth = true;
      for (const auto& [dx, dy] : {std::pair{-2, 0}, {2, 0}, {0, -2}, {0, 2}})
        smooth = smooth && std::abs(frame.depth(y + dy, x + dx) - z) < kJump * z;
      if (smooth) key.inverse_depth(y / 2, x / 2) = 1.F / z;
    }
  const float soft2 = static_cast<float>(options.softness * options.softness);
  for (const SelectedPixel& selected : pixels) {
    WindowPoint point{.u = static_cast<float>(selected.pixel.x),
                      .v = static_cast<float>(selected.pixel.y)};
    point.measured = point.inverse_depth = 1.0 / static_cast<double>(selected.depth);
    const double bias = options.depth_bias * point.measured;
    point.weight = 1.0 / (options.depth_noise * options.depth_noise + bias * bias);
    for (std::size_t k = 0; k < kPatchSize; ++k) {
      const int x = selected.pixel.x + static_cast<int>(kPatternX[k]);
      const int y = selected.pixel.y + static_cast<int>(kPatternY[k]);
      const float gx = 0.5F * static_cast<float>(gray(y, x + 1) - gray(y, x - 1));
      const float gy = 0.5F * static_cast<float>(gray(y + 1, x) - gray(y - 1, x));
      point.intensity[k] = gray(y, x);
      point.softness[k] = soft2 / (soft2 + gx * gx + gy * gy);
    }
    key.points.push_back(point);
  }
  return key;
}

double shared_view(const WindowKeyframe& host, const WindowKeyframe& target, const Camera& camera) {
  const SE3 target_from_host = inverse(target.world_from_key) * host.world_from_key;
  int seen = 0, tried = 0;
  for (std::size_t i = 0; i < host.points.size(); i += 5) {
    const WindowPoint& point = host.points[i];
    const double z = 1 / point.inverse_depth;
    const Eigen::Vector3d x = target_from_host * back_project(camera, point.u, point.v, z);
    ++tried;
    if (x.z() < 0.5 * z || x.z() > 2 * z) continue;  // too different in scale to match patches
    const Eigen::Vector2d pixel = project(camera, x);
    seen += pixel.x() > 3 && pixel.y() > 3 && pixel.x() < camera.width - 4 &&
            pixel.y() < camera.height - 4;
  }
  return tried > 0 ? static_cast<double>(seen) / tried : 0.0;
}

WindowSummary refine_window(std::vector<WindowKeyframe>& window, const Camera& camera, int fixed,
                            const WindowOptions& wanted, std::vector<PairModel>& memory) {
  const int count = static_cast<int>(window.size());
  fixed = std::min(fixed, count - 1);
  if (count < 2) return {};
  WindowOptions options = wanted;
  const double scale = depth_scale(window, camera, wanted);
  options.depth_noise *= scale;
  options.depth_bias *= scale;
  std::vector<PairModel> models = recall(memory, window);
  WindowSystem others =
      linearize_window(window, camera, fixed, WindowPairs::kOthers, options, models);
  WindowSystem newest =
      linearize_window(window, camera, fixed, WindowPairs::kNewest, options, models);
  const double first_cost = others.cost + newest.cost;
  WindowSummary summary{1, first_cost, first_cost, false};
  Relaxation relaxation;
  while (summary.iterations < options.iterations) {
    WindowStep step = solve(others, newest, kDamping);
    summary.converged = true;  // unless this step is a good one
    if (!step.keyframes.allFinite()) break;
    lengthen(step, relaxation.next(step));
    std::vector<WindowKeyframe> moved = window;
    apply_step(step, fixed, moved);
    move_by(step, others);
    newest = linearize_window(moved, camera, fixed, WindowPairs::kNewest, options, models);
    const double gained = summary.last_cost - (others.cost + newest.cost);
    if (!(gained > 0)) break;  // nor where it is not a number
    ++summary.iterations;
    window = std::move(moved);
    summary.last_cost -= gained;
    summary.converged = gained < kWorthAnother * summary.last_cost;
    if (gained < options.tolerance * summary.last_cost) break;
  }
  std::erase_if(models, [](const PairModel& model) { return model.depths.empty(); });
  memory = std::move(models);
  return summary;
}

}  // namespace edvo
