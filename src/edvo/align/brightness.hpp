// SPDX-License-Identifier: MIT
// What is expected of an image's brightness against another's: I = gain * I_other + bias, and how
// gain and bias stand as unknowns beside a pose.
#pragma once

namespace edvo {

constexpr double kBrightnessUnit = 64.0;  // [grey levels] makes gain and bias steps of like size

// Exposure rarely jumps by more than this. Unknowns: gain, bias / kBrightnessUnit.
struct BrightnessPrior {
  double gain_weight, bias_weight, gain_error, bias_error;

  // at: of the gain; the bias is the unknown after it.
  template <typename System>
  void add_to(System& system, int at) const {
    system.hessian(at, at) += gain_weight;
    system.hessian(at + 1, at + 1) += bias_weight;
    system.gradient[at] += gain_weight * gain_error;
    system.gradient[at + 1] += bias_weight * bias_error;
    system.cost +=
        0.5 * (gain_weight * gain_error * gain_error + bias_weight * bias_error * bias_error);
  }
};

// scale: of the weights; a large one holds gain and bias at 1 and 0.
[[nodiscard]] inline BrightnessPrior brightness_prior(double gain, double bias, double scale = 1) {
  constexpr double kGainSigma = 0.3;
  constexpr double kBiasSigma = 30.0;  // [grey levels]
  return {.gain_weight = scale / (kGainSigma * kGainSigma),
          .bias_weight = scale * kBrightnessUnit * kBrightnessUnit / (kBiasSigma * kBiasSigma),
          .gain_error = gain - 1,
          .bias_error = bias / kBrightnessUnit};
}

}  // namespace edvo
