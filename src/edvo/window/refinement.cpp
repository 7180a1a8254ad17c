// SPDX-License-Identifier: MIT
#include "edvo/window/refinement.hpp"

#include "edvo/align/aitken.hpp"
#include "edvo/align/robust.hpp"
#include "edvo/window/keyframe_unknowns.hpp"

#include <algorithm>
#include <limits>

namespace edvo {
namespace {

constexpr double kDamping = 1e-4;
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

void remember(std::vector<PairModel>&& models, std::vector<PairModel>& memory) {
  std::erase_if(models, [](const PairModel& model) { return model.depths.empty(); });
  memory = std::move(models);
}

}  // namespace

double Relaxation::next(const WindowStep& step) {
  const double own = -step.gradient.dot(step.keyframes);
  if (last_.size() > 0) {
    const double cross = -step.gradient.dot(last_);
    factor_ = steps_at_once(steps_to_come(factor_, last_own_, cross, own));
  }
  last_ = step.keyframes;
  last_own_ = own;
  return factor_;
}

Refinement begin_refinement(const std::vector<WindowKeyframe>& window, const Camera& camera,
                            int fixed, const WindowOptions& options,
                            std::vector<PairModel>& memory) {
  const int count = static_cast<int>(window.size());
  Refinement r{.camera = camera, .fixed = std::min(fixed, count - 1), .options = options};
  if (count < 2) return r;
  const double scale = depth_scale(window, camera, options);
  r.options.depth_noise *= scale;
  r.options.depth_bias *= scale;
  std::vector<PairModel> models = recall(memory, window);
  r.others = linearize_window(window, camera, r.fixed, WindowPairs::kOthers, r.options, models);
  r.newest = linearize_window(window, camera, r.fixed, WindowPairs::kNewest, r.options, models);
  remember(std::move(models), memory);
  r.iterations = 1;
  r.first_cost = r.cost = r.others.cost + r.newest.cost;
  r.finished = r.iterations >= options.iterations;
  return r;
}

void advance(Refinement& r, std::vector<WindowKeyframe>& window, int steps,
             std::vector<PairModel>& memory) {
  if (r.finished) return;
  std::vector<PairModel> models = recall(memory, window);
  for (; steps > 0 && !r.finished; --steps) {
    WindowStep step = solve(r.others, r.newest, kDamping);
    r.finished = true;  // unless this step is a good one
    if (!step.keyframes.allFinite()) break;
    lengthen(step, r.relaxation.next(step));
    const Estimates before = estimates_of(window);
    apply_step(step, r.fixed, window);
    move_by(step, r.others);
    r.newest = linearize_window(window, r.camera, r.fixed, WindowPairs::kNewest, r.options, models);
    const double gained = r.cost - (r.others.cost + r.newest.cost);
    if (!(gained > 0)) {  // nor where it is not a number
      restore(before, window);
      break;
    }
    r.cost -= gained;
    r.finished = ++r.iterations >= r.options.iterations || gained < r.options.tolerance * r.cost;
  }
  remember(std::move(models), memory);
}

Refinement refine_window(std::vector<WindowKeyframe>& window, const Camera& camera, int fixed,
                         const WindowOptions& options, std::vector<PairModel>& memory) {
  Refinement refinement = begin_refinement(window, camera, fixed, options, memory);
  advance(refinement, window, options.iterations, memory);
  return refinement;
}

}  // namespace edvo
