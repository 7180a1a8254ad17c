// SPDX-License-Identifier: MIT
#include "edvo/synth/texture.hpp"

#include "edvo/synth/random.hpp"

#include <algorithm>
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

// Smooth noise [0..1] on a periodic lattice of cells_u x cells_v.
double value_noise(double u, double v, int cells_u, int cells_v, std::uint64_t seed) {
  const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const double x = u * cells_u, y = v * cells_v;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const auto corner = [&](int dx, int dy) {
    const auto column = static_cast<std::uint64_t>(((x0 + dx) % cells_u + cells_u) % cells_u);
    const auto row = static_cast<std::uint64_t>(((y0 + dy) % cells_v + cells_v) % cells_v);
    return static_cast<double>(mix(seed + mix(column * 65537 + row)) >> 11) * 0x1p-53;
  };
  const double fx = fade(x - x0), fy = fade(y - y0);
  return std::lerp(std::lerp(corner(0, 0), corner(1, 0), fx),
                   std::lerp(corner(0, 1), corner(1, 1), fx), fy);
}

// Octaves of value noise, each of twice the frequency and half the amplitude. [0..1]
double fractal_noise(double u, double v, int cells_u, int cells_v, int octaves,
                     std::uint64_t seed) {
  double sum = 0, amplitude = 1, total = 0;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += amplitude * value_noise(u, v, cells_u << octave, cells_v << octave, seed + octave);
    total += amplitude;
    amplitude *= 0.5;
  }
  return sum / total;
}

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
  const std::uint64_t picture = random.word();
  for (int y = kSize * 22 / 100; y < static_cast<int>(kSize * (0.22 + split * 0.8)); ++y)
    for (int x = kSize * 7 / 100; x < kSize * 93 / 100; ++x) {
      const double noise = fractal_noise((x + 0.5) / kSize, (y + 0.5) / kSize, 4, 4, 4, picture);
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

double wood(double u, double v, std::uint64_t seed) {
  constexpr int kPlanks = 4;
  const int plank = static_cast<int>(v * kPlanks);
  const double shade = value_noise(0.5, (plank + 0.5) / kPlanks, 1, kPlanks, seed + 99);
  const double grain = fractal_noise(u, v, 3, 48, 4, seed + plank);
  const double rings = 0.5 + 0.5 * std::sin(40 * std::numbers::pi *
                                            (v + 0.15 * fractal_noise(u, v, 2, 4, 2, seed + 7)));
  const double joint = fraction(v * kPlanks) < 0.03 ? 0.0 : 1.0;
  return joint * (0.2 + 0.3 * shade + 0.35 * grain + 0.15 * rings);
}

double tiles(double u, double v, std::uint64_t seed) {
  constexpr int kCount = 4;
  const double x = fraction(u * kCount), y = fraction(v * kCount);
  if (x < 0.03 || y < 0.03) return 0.1;
  const bool dark = (static_cast<int>(u * kCount) + static_cast<int>(v * kCount)) % 2 == 1;
  return (dark ? 0.35 : 0.75) + 0.25 * (fractal_noise(u, v, 16, 16, 4, seed) - 0.5);
}

double bricks(double u, double v, std::uint64_t seed) {
  constexpr int kRows = 12, kColumns = 4;
  const int row = static_cast<int>(v * kRows);
  const double x = u * kColumns + (row % 2) * 0.5;
  if (fraction(v * kRows) < 0.12 || fraction(x) < 0.04) return 0.85;
  const auto brick = static_cast<std::uint64_t>(row * kColumns + static_cast<int>(x) % kColumns);
  const double shade = static_cast<double>(mix(seed + brick) >> 11) * 0x1p-53;
  return 0.15 + 0.35 * shade + 0.2 * fractal_noise(u, v, 24, 24, 3, seed);
}

double speckle(double u, double v, std::uint64_t seed) {
  const double coarse = fractal_noise(u, v, 32, 32, 3, seed);
  return std::clamp(0.5 + 2.2 * (coarse - 0.5), 0.0, 1.0);
}

double fabric(double u, double v, std::uint64_t seed) {
  const double weave = std::sin(128 * std::numbers::pi * u) * std::sin(128 * std::numbers::pi * v);
  return 0.45 + 0.1 * weave + 0.6 * (fractal_noise(u, v, 6, 6, 4, seed) - 0.5);
}

double carpet(double u, double v, std::uint64_t seed) {
  const double ornament = std::sin(8 * std::numbers::pi * u) * std::sin(8 * std::numbers::pi * v);
  return 0.5 + (ornament > 0.2 ? 0.18 : -0.1) + 0.5 * (fractal_noise(u, v, 20, 20, 4, seed) - 0.5);
}

void paint_pattern(Canvas& canvas, Pattern pattern, std::uint64_t seed) {
  const auto paint_with = [&](double (*function)(double, double, std::uint64_t)) {
    paint(canvas, [&](double u, double v) { return function(u, v, seed); });
  };
  switch (pattern) {
    case Pattern::kPlain:
      return paint(canvas, [](double, double) { return 0.5; });
    case Pattern::kPlaster:
      return paint(canvas, [&](double u, double v) { return fractal_noise(u, v, 4, 4, 6, seed); });
    case Pattern::kWood:
      return paint_with(wood);
    case Pattern::kCarpet:
      return paint_with(carpet);
    case Pattern::kTiles:
      return paint_with(tiles);
    case Pattern::kBricks:
      return paint_with(bricks);
    case Pattern::kStripes:
      return paint(canvas, [](double u, double) { return fraction(8 * u) < 0.4 ? 0.2 : 0.8; });
    case Pattern::kFabric:
      return paint_with(fabric);
    case Pattern::kPoster:
      return paint_poster(canvas, seed);
    case Pattern::kScreen:
      return paint_screen(canvas, seed);
    case Pattern::kKeys:
      return paint_keys(canvas, seed);
    case Pattern::kBook:
      return paint_book(canvas, seed);
    case Pattern::kSpeckle:
      return paint_with(speckle);
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

// Bilinear, wrapping; texel centres lie at (i + 0.5) / size.
float sample_level(const Texture::Level& level, float u, float v) {
  const auto size = static_cast<float>(level.size);
  const float x = u * size - 0.5F, y = v * size - 0.5F;
  const float x_floor = std::floor(x), y_floor = std::floor(y);
  const float fx = x - x_floor, fy = y - y_floor;
  const int mask = level.size - 1;
  const int x0 = static_cast<int>(x_floor) & mask, y0 = static_cast<int>(y_floor) & mask;
  const int x1 = (x0 + 1) & mask;
  const float* above = &level.values[y0 * level.size];
  const float* below = &level.values[((y0 + 1) & mask) * level.size];
  const float top = above[x0] + fx * (above[x1] - above[x0]);
  const float bottom = below[x0] + fx * (below[x1] - below[x0]);
  return top + fy * (bottom - top);
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

float sample(const Texture& texture, float u, float v, float lod) {
  const auto coarsest = static_cast<float>(texture.levels.size() - 1);
  const float level = std::clamp(lod, 0.0F, coarsest);
  const auto fine = static_cast<std::size_t>(level);
  const float blend = level - static_cast<float>(fine);
  const float value = sample_level(texture.levels[fine], u, v);
  if (blend == 0.0F) return value;
  return value + blend * (sample_level(texture.levels[fine + 1], u, v) - value);
}

}  // namespace edvo::synth
