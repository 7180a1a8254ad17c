// SPDX-License-Identifier: MIT
#include "edvo/synth/texture.hpp"

#include "edvo/synth/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace edvo::synth {
namespace {

constexpr int kSize = 512;  // [texels]

// A picture in the making: coordinates and sizes in tiles [0..1], wrapping around.
struct Canvas {
  std::vector<float> values = std::vector<float>(kSize * kSize, 0.0F);

  float& at(int x, int y) { return values[(y & (kSize - 1)) * kSize + (x & (kSize - 1))]; }
};

template <typename Function>  // Function(u, v) -> value
void paint(Canvas& canvas, const Function& function) {
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      canvas.at(x, y) = static_cast<float>(function((x + 0.5) / kSize, (y + 0.5) / kSize));
}

void fill(Canvas& canvas, double u, double v, double width, double height, double value) {
  const auto texel = [](double tiles) { return static_cast<int>(std::lround(tiles * kSize)); };
  for (int y = texel(v); y < texel(v + height); ++y)
    for (int x = texel(u); x < texel(u + width); ++x) canvas.at(x, y) = static_cast<float>(value);
}

// Octaves of smooth periodic noise, each of twice the frequency and half the amplitude. [0..1]
class Noise {
 public:
  Noise(int cells_u, int cells_v, int octaves, std::uint64_t seed) {
    Random random{seed};
    for (int octave = 0; octave < octaves; ++octave) {
      Lattice lattice{.cells_u = cells_u << octave, .cells_v = cells_v << octave, .values = {}};
      for (int i = 0; i < lattice.cells_u * lattice.cells_v; ++i)
        lattice.values.push_back(random.uniform());
      lattices_.push_back(std::move(lattice));
    }
  }

  [[nodiscard]] double operator()(double u, double v) const {
    double sum = 0, amplitude = 1, total = 0;
    for (const Lattice& lattice : lattices_) {
      sum += amplitude * lattice.at(u, v);
      total += amplitude;
      amplitude *= 0.5;
    }
    return sum / total;
  }

 private:
  struct Lattice {
    int cells_u = 0, cells_v = 0;
    std::vector<double> values;

    [[nodiscard]] double at(double u, double v) const {  // u and v not negative [tiles]
      const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
      const double x = u * cells_u, y = v * cells_v;
      const auto column = static_cast<int>(x), row = static_cast<int>(y);
      const double fx = fade(x - column), fy = fade(y - row);
      const int x0 = column % cells_u, x1 = (column + 1) % cells_u;
      const double* above = &values[row % cells_v * cells_u];
      const double* below = &values[(row + 1) % cells_v * cells_u];
      const double top = above[x0] + fx * (above[x1] - above[x0]);
      const double bottom = below[x0] + fx * (below[x1] - below[x0]);
      return top + fy * (bottom - top);
    }
  };
  std::vector<Lattice> lattices_;
};

double fraction(double x) {
  return x - std::floor(x);
}

// Words as little bars on lines, as print looks from a distance.
void print_text(Canvas& canvas, double u, double v, double width, double height, double line,
                double ink, Random& random) {
  for (double y = v; y + 0.6 * line <= v + height; y += line) {
    const double end = u + width * random.uniform(0.6, 1.0);
    for (double x = u; x < end;) {
      const double word = std::min(line * random.uniform(0.6, 3.0), end - x);
      fill(canvas, x, y, word, 0.55 * line, ink + random.uniform(-0.08, 0.08));
      x += word + 0.4 * line;
    }
  }
}

void paint_poster(Canvas& canvas, std::uint64_t seed) {
  Random random{seed};
  const double paper = random.uniform(0.8, 1.0);
  fill(canvas, 0, 0, 1, 1, 0.15);
  fill(canvas, 0.015, 0.015, 0.97, 0.97, paper);
  print_text(canvas, 0.07, 0.06, 0.86, 0.12, 0.1, 0.05, random);
  const double split = random.uniform(0.35, 0.6);
  const Noise picture(4, 4, 4, random.word());
  for (int y = kSize * 22 / 100; y < static_cast<int>(kSize * (0.22 + split * 0.8)); ++y)
    for (int x = kSize * 7 / 100; x < kSize * 93 / 100; ++x) {
      const double noise = picture((x + 0.5) / kSize, (y + 0.5) / kSize);
      canvas.at(x, y) = static_cast<float>(std::floor(noise * 7) / 6);
    }
  const double text = 0.22 + split * 0.8 + 0.04;
  print_text(canvas, 0.07, text, 0.4, 0.93 - text, random.uniform(0.025, 0.045), 0.2, random);
  print_text(canvas, 0.53, text, 0.4, 0.93 - text, random.uniform(0.025, 0.045), 0.2, random);
}

void paint_screen(Canvas& canvas, std::uint64_t seed) {
  Random random{seed};
  fill(canvas, 0, 0, 1, 1, 0.02);
  fill(canvas, 0.03, 0.04, 0.94, 0.92, 0.45);
  for (int window = 0; window < 4; ++window) {
    const double u = random.uniform(0.05, 0.45), v = random.uniform(0.06, 0.4);
    const double width = random.uniform(0.3, 0.5), height = random.uniform(0.35, 0.52);
    fill(canvas, u, v, width, height, random.uniform() < 0.5 ? 0.95 : 0.15);
    const bool dark = canvas.at(static_cast<int>((u + 0.01) * kSize),
                                static_cast<int>((v + 0.01) * kSize)) < 0.5F;
    fill(canvas, u, v, width, 0.035, 0.6);
    print_text(canvas, u + 0.02, v + 0.06, width - 0.04, height - 0.08, 0.028, dark ? 0.8 : 0.2,
               random);
  }
}

void paint_keys(Canvas& canvas, std::uint64_t seed) {
  Random random{seed};
  fill(canvas, 0, 0, 1, 1, 0.25);
  constexpr int kRows = 6, kColumns = 18;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const double u = 0.02 + 0.96 * column / kColumns, v = 0.04 + 0.92 * row / kRows;
      fill(canvas, u, v, 0.96 / kColumns * 0.85, 0.92 / kRows * 0.85, random.uniform(0.65, 0.9));
      fill(canvas, u + 0.012, v + 0.03, 0.015, 0.06, 0.1);
    }
}

void paint_book(Canvas& canvas, std::uint64_t seed) {
  Random random{seed};
  const double cover = random.uniform(0.5, 1.0);
  fill(canvas, 0, 0, 1, 1, cover);
  const double band = random.uniform(0.1, 0.3);
  fill(canvas, 0, band, 1, 0.04, 1.0 - cover);
  fill(canvas, 0, 0.9, 1, 0.03, 1.0 - cover);
  fill(canvas, 0.3, band + 0.12, 0.4, random.uniform(0.2, 0.4), 0.1);
}

void paint_wood(Canvas& canvas, std::uint64_t seed) {
  constexpr int kPlanks = 4;
  const Noise shades(1, kPlanks, 1, seed + 1), grains(3, 48, 4, seed + 2), bends(2, 4, 2, seed + 3);
  paint(canvas, [&](double u, double v) {
    if (fraction(v * kPlanks) < 0.03) return 0.0;  // the joint
    const auto plank = static_cast<int>(v * kPlanks);
    const double shade = shades(0, static_cast<double>(plank) / kPlanks);
    const double grain = grains(u + 0.31 * plank, v);
    const double rings = std::sin(40 * std::numbers::pi * (v + 0.15 * bends(u, v)));
    return 0.275 + 0.3 * shade + 0.35 * grain + 0.075 * rings;
  });
}

void paint_tiles(Canvas& canvas, std::uint64_t seed) {
  constexpr int kCount = 4;
  const Noise clouds(16, 16, 4, seed);
  paint(canvas, [&](double u, double v) {
    if (fraction(u * kCount) < 0.03 || fraction(v * kCount) < 0.03) return 0.1;
    const bool dark = (static_cast<int>(u * kCount) + static_cast<int>(v * kCount)) % 2 == 1;
    return (dark ? 0.35 : 0.75) + 0.25 * (clouds(u, v) - 0.5);
  });
}

void paint_bricks(Canvas& canvas, std::uint64_t seed) {
  constexpr int kRows = 12, kColumns = 4;
  const Noise grain(24, 24, 3, seed);
  Random random{seed};
  std::array<double, kRows * kColumns> shades;
  for (double& shade : shades) shade = random.uniform();
  paint(canvas, [&](double u, double v) {
    const auto row = static_cast<int>(v * kRows);
    const double x = u * kColumns + (row % 2) * 0.5;
    if (fraction(v * kRows) < 0.12 || fraction(x) < 0.04) return 0.85;
    const double shade = shades[row * kColumns + static_cast<int>(x) % kColumns];
    return 0.15 + 0.35 * shade + 0.2 * grain(u, v);
  });
}

void paint_speckle(Canvas& canvas, std::uint64_t seed) {
  const Noise spots(32, 32, 3, seed);
  paint(canvas, [&](double u, double v) { return 0.5 + 2.2 * (spots(u, v) - 0.5); });
}

void paint_fabric(Canvas& canvas, std::uint64_t seed) {
  const Noise spots(6, 6, 4, seed);
  paint(canvas, [&](double u, double v) {
    const double weave =
        std::sin(128 * std::numbers::pi * u) * std::sin(128 * std::numbers::pi * v);
    return 0.45 + 0.1 * weave + 0.6 * (spots(u, v) - 0.5);
  });
}

void paint_carpet(Canvas& canvas, std::uint64_t seed) {
  const Noise pile(20, 20, 4, seed);
  paint(canvas, [&](double u, double v) {
    const double ornament = std::sin(8 * std::numbers::pi * u) * std::sin(8 * std::numbers::pi * v);
    return 0.5 + (ornament > 0.2 ? 0.18 : -0.1) + 0.5 * (pile(u, v) - 0.5);
  });
}

void paint_pattern(Canvas& canvas, Pattern pattern, std::uint64_t seed) {
  switch (pattern) {
    case Pattern::kPlain:
      return paint(canvas, [](double, double) { return 0.5; });
    case Pattern::kPlaster:
      return paint(canvas, Noise(4, 4, 6, seed));
    case Pattern::kWood:
      return paint_wood(canvas, seed);
    case Pattern::kCarpet:
      return paint_carpet(canvas, seed);
    case Pattern::kTiles:
      return paint_tiles(canvas, seed);
    case Pattern::kBricks:
      return paint_bricks(canvas, seed);
    case Pattern::kStripes:
      return paint(canvas, [](double u, double) { return fraction(8 * u) < 0.4 ? 0.2 : 0.8; });
    case Pattern::kFabric:
      return paint_fabric(canvas, seed);
    case Pattern::kPoster:
      return paint_poster(canvas, seed);
    case Pattern::kScreen:
      return paint_screen(canvas, seed);
    case Pattern::kKeys:
      return paint_keys(canvas, seed);
    case Pattern::kBook:
      return paint_book(canvas, seed);
    case Pattern::kSpeckle:
      return paint_speckle(canvas, seed);
  }
}

Texture::Level halve(const Texture::Level& fine) {
  const int size = fine.size / 2;
  Texture::Level coarse{.size = size, .values = std::vector<float>(size * size)};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const float* above = &fine.values[2 * y * fine.size + 2 * x];
      const float* below = above + fine.size;
      coarse.values[y * size + x] = 0.25F * (above[0] + above[1] + below[0] + below[1]);
    }
  return coarse;
}

// The mean of four bilinear samples, wrapping; texel centres lie at (i + 0.5) / size.
float mean_in_level(const Texture::Level& level, const Eigen::Array4f& u, const Eigen::Array4f& v) {
  const auto size = static_cast<float>(level.size);
  const Eigen::Array4f x = u * size - 0.5F, y = v * size - 0.5F;
  const Eigen::Array4f x_floor = x.floor(), y_floor = y.floor();
  const Eigen::Array4f fx = x - x_floor, fy = y - y_floor;
  const Eigen::Array4i column = x_floor.cast<int>(), row = y_floor.cast<int>();
  const int mask = level.size - 1;
  const float* texels = level.values.data();
  Eigen::Array4f corners[2][2];
  for (int i = 0; i < 4; ++i) {
    const int x0 = column[i] & mask, x1 = (column[i] + 1) & mask;
    const float* above = texels + (row[i] & mask) * level.size;
    const float* below = texels + ((row[i] + 1) & mask) * level.size;
    corners[0][0][i] = above[x0];
    corners[0][1][i] = above[x1];
    corners[1][0][i] = below[x0];
    corners[1][1][i] = below[x1];
  }
  const Eigen::Array4f top = corners[0][0] + fx * (corners[0][1] - corners[0][0]);
  const Eigen::Array4f bottom = corners[1][0] + fx * (corners[1][1] - corners[1][0]);
  return 0.25F * (top + fy * (bottom - top)).sum();
}

}  // namespace

Texture make_texture(Pattern pattern, std::uint64_t seed) {
  Canvas canvas;
  paint_pattern(canvas, pattern, seed);
  for (float& value : canvas.values) value = std::clamp(value, 0.0F, 1.0F);
  Texture texture;
  texture.levels.push_back({.size = kSize, .values = std::move(canvas.values)});
  while (texture.levels.back().size > 1) texture.levels.push_back(halve(texture.levels.back()));
  return texture;
}

float mean_of_four(const Texture& texture, const Eigen::Array4f& u, const Eigen::Array4f& v,
                   float lod) {
  const auto coarsest = static_cast<float>(texture.levels.size() - 1);
  const float level = std::clamp(lod, 0.0F, coarsest);
  const auto fine = static_cast<std::size_t>(level);
  const float blend = level - static_cast<float>(fine);
  const float value = mean_in_level(texture.levels[fine], u, v);
  if (blend == 0.0F) return value;
  return value + blend * (mean_in_level(texture.levels[fine + 1], u, v) - value);
}

float sample(const Texture& texture, float u, float v, float lod) {
  return mean_of_four(texture, Eigen::Array4f::Constant(u), Eigen::Array4f::Constant(v), lod);
}

}  // namespace edvo::synth
