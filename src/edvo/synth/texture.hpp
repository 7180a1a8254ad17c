// SPDX-License-Identifier: MIT
// Procedural surface patterns, filtered for every viewing distance.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace edvo::synth {

enum class Pattern {
  kPlain,    // nothing at all
  kPlaster,  // faint cloudy noise
  kWood,     // long grain and planks
  kCarpet,   // fine noise with a woven pattern
  kTiles,    // checker with joints
  kBricks,
  kStripes,
  kFabric,   // weave and large spots
  kPoster,   // title, picture and lines of text
  kScreen,   // windows with text
  kKeys,     // a keyboard
  kBook,     // the back of a book
  kSpeckle,  // granite
};

// A square, periodic pattern of values [0..1] with its mip levels.
struct Texture {
  struct Level {
    int size = 0;  // [texels], a power of two
    std::vector<float> values;
  };
  std::vector<Level> levels;  // finest first, the last is one texel
};

// The same pattern and seed give the same texture.
[[nodiscard]] Texture make_texture(Pattern pattern, std::uint64_t seed);

// The value at (u, v) [tiles], averaged over 2^lod texels of the finest level (trilinear).
[[nodiscard]] float sample(const Texture& texture, float u, float v, float lod);

// The mean of sample() at four places.
[[nodiscard]] float mean_of_four(const Texture& texture, const Eigen::Array4f& u,
                                 const Eigen::Array4f& v, float lod);

}  // namespace edvo::synth
