// SPDX-License-Identifier: MIT
#include "edvo/image/depth.hpp"

#include <algorithm>

namespace edvo {

void Depth::look_up(std::vector<std::int32_t>& pixels, std::vector<float>& depths) const {
  const std::size_t count = pixels.size();
  depths.resize(count);
  // In two loops, so that the memory works on many of these scattered reads at a time.
  if (const std::int32_t* sources = sources_.empty() ? nullptr : sources_[0])
    for (std::size_t i = 0; i < count; ++i)
      pixels[i] = pixels[i] < 0 ? pixels[i] : sources[pixels[i]];
  const float* values = values_[0];
  for (std::size_t i = 0; i < count; ++i)
    depths[i] = pixels[i] < 0 ? std::numeric_limits<float>::quiet_NaN() : values[pixels[i]];
}

cv::Mat_<float> Depth::undistorted() const {
  if (sources_.empty()) return values_;
  cv::Mat_<float> result(size());
  const float* in = values_[0];
  const std::int32_t* sources = sources_[0];
  float* out = result[0];
  const std::size_t count = result.total();
  for (std::size_t i = 0; i < count; ++i) {
    const float z = in[std::max(sources[i], 0)];
    out[i] = sources[i] < 0 ? std::numeric_limits<float>::quiet_NaN() : z;
  }
  return result;
}

}  // namespace edvo
