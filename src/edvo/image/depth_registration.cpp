// SPDX-License-Identifier: MIT
#include "edvo/image/depth_registration.hpp"

#include "edvo/core/error.hpp"
#include "edvo/simd/dispatch.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace edvo {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// Neighbours further apart than on a surface seen under so flat an angle are not on one surface.
constexpr double kFlattestAngle = 85 * 3.14159265358979323846 / 180;  // [rad] off the normal
constexpr float kLargestSpread = 4;  // times the usual distance of neighbours in the colour image

void check(const char* name, const Camera& camera) {
  if (camera.width <= 0 || camera.height <= 0 || camera.fx == 0 || camera.fy == 0)
    throw Error(ErrorCode::kCalibration,
                fmt::format("{} camera: {} x {} px, focal length {} {}: must not be zero", name,
                            camera.width, camera.height, camera.fx, camera.fy));
}

// The ideal image point (z = 1) of a pixel.
Eigen::Vector2d ray_of(const DistortedCamera& camera, double u, double v) {
  const Camera& k = camera.pinhole;
  return undistort(camera, {(u - k.cx) / k.fx, (v - k.cy) / k.fy});
}

// Beyond it the polynomial of the distortion may fold points back into the image.
float largest_radius(const DistortedCamera& camera) {
  constexpr double kMargin = 1.1;
  double largest = 0;
  for (const double u : {0.0, camera.pinhole.width - 1.0})
    for (const double v : {0.0, camera.pinhole.height - 1.0})
      largest = std::max(largest, ray_of(camera, u, v).squaredNorm());
  return static_cast<float>(largest * kMargin * kMargin);
}

// below: rows do not overlap, and without that promise loops over so many are not
// vectorized.

// A row of the depth image in the colour camera; one pixel without depth before and after it.
struct ProjectedRow {
  explicit ProjectedRow(int width)
      : u(width + 2, kNone), v(width + 2, kNone), z(width + 2, kNone) {}
  std::vector<float> u, v;  // [px]
  std::vector<float> z;     // [m]
};

// What the pixels of a row cover in the colour image, first to last pixel, and the depth there:
// z + slope_u * (pixel - u) + slope_v * (pixel - v).
struct Footprints {
  explicit Footprints(int width)
      : first_u(width),
        last_u(width),
        first_v(width),
        last_v(width),
        slope_u(width),
        slope_v(width) {}
  std::vector<std::int32_t> first_u, last_u, first_v, last_v;
  std::vector<float> slope_u, slope_v;  // [m / px]
};

EDVO_CLONES void project_polynomial(const DepthRegistration& registration, const float* depth,
                                    int row, ProjectedRow& projected) {
  const int width = registration.ray_x.cols;
  const float* ray_x = registration.ray_x[row];
  const float* ray_y = registration.ray_y[row];
  const float* ray_z = registration.ray_z[row];
  const float ox = registration.origin.x(), oy = registration.origin.y(),
              oz = registration.origin.z();
  const Camera& camera = registration.colour.pinhole;
  const float fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy),
              cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  std::array<float, 8> k{};  // zero for an equidistant lens, which bends later
  if (registration.colour.lens == LensModel::kPolynomial)
    std::copy_n(registration.colour.distortion.begin(), k.size(), k.begin());
  const float limit = registration.largest_radius;
  float* u = projected.u.data() + 1;
  float* v = projected.v.data() + 1;
  float* z = projected.z.data() + 1;
  EDVO_INDEPENDENT
  for (int i = 0; i < width; ++i) {
    const float d = depth[i];
    const float depth_here = ray_z[i] * d + oz;
    const float inverse = 1 / depth_here;
    const float x = (ray_x[i] * d + ox) * inverse, y = (ray_y[i] * d + oy) * inverse;
    const float r2 = x * x + y * y;
    const float radial =
        (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    u[i] = fx * (x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)) + cx;
    v[i] = fy * (y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y) + cy;
    z[i] = depth_here > 0 && r2 <= limit ? depth_here : kNone;
  }
}

// From where an ideal pinhole sees them to where an equidistant lens does.
void bend_row(const DistortedCamera& colour, ProjectedRow& projected) {
  const Camera& k = colour.pinhole;
  for (std::size_t i = 0; i < projected.u.size(); ++i) {
    const Eigen::Vector2d at =
        distort(colour, {(projected.u[i] - k.cx) / k.fx, (projected.v[i] - k.cy) / k.fy});
    projected.u[i] = static_cast<float>(k.fx * at.x() + k.cx);
    projected.v[i] = static_cast<float>(k.fy * at.y() + k.cy);
  }
}

void project_row(const DepthRegistration& registration, const float* depth, int row,
                 ProjectedRow& projected) {
  project_polynomial(registration, depth, row, projected);
  if (registration.colour.lens == LensModel::kEquidistant) bend_row(registration.colour, projected);
}

// Of numbers from -1 on; conversions are vectorized, std::ceil and std::floor not everywhere. A
// pixel's centre a part in 100,000 before an area counts as in it.
[[gnu::always_inline]] inline std::int32_t round_up(float value) {
  return static_cast<std::int32_t>(value + 0.99999F);
}
[[gnu::always_inline]] inline std::int32_t round_down(float value) {
  return static_cast<std::int32_t>(value + 1) - 1;
}

// Differences to the neighbour after or, where that is on another surface, before.
EDVO_CLONES void find_footprints(const DepthRegistration& registration, const ProjectedRow& above,
                                 const ProjectedRow& here, const ProjectedRow& below,
                                 Footprints& out) {
  const Camera& depth = registration.depth.pinhole;
  const Camera& colour = registration.colour.pinhole;
  const int width = depth.width;
  const float jump = static_cast<float>(std::tan(kFlattestAngle) / std::abs(depth.fx));
  const float usual_u = static_cast<float>(std::abs(colour.fx / depth.fx));
  const float usual_v = static_cast<float>(std::abs(colour.fy / depth.fy));
  const float right_most = static_cast<float>(colour.width - 1);
  const float bottom_most = static_cast<float>(colour.height - 1);
  const float most_u = 0.5F * kLargestSpread * usual_u, most_v = 0.5F * kLargestSpread * usual_v;
  const float* u = here.u.data() + 1;
  const float* v = here.v.data() + 1;
  const float* z = here.z.data() + 1;
  const float* above_u = above.u.data() + 1;
  const float* above_v = above.v.data() + 1;
  const float* above_z = above.z.data() + 1;
  const float* below_u = below.u.data() + 1;
  const float* below_v = below.v.data() + 1;
  const float* below_z = below.z.data() + 1;
  float* slope_u = out.slope_u.data();
  float* slope_v = out.slope_v.data();
  std::int32_t* first_u = out.first_u.data();
  std::int32_t* last_u = out.last_u.data();
  std::int32_t* first_v = out.first_v.data();
  std::int32_t* last_v = out.last_v.data();
  EDVO_INDEPENDENT
  for (int i = 0; i < width; ++i) {
    const float most = jump * z[i];
    // All differences first: a choice between numbers that are there is vectorized.
    const float after_u = u[i + 1] - u[i], before_u = u[i] - u[i - 1];
    const float after_v = v[i + 1] - v[i], before_v = v[i] - v[i - 1];
    const float after_z = z[i + 1] - z[i], before_z = z[i] - z[i - 1];
    const float under_u = below_u[i] - u[i], over_u = u[i] - above_u[i];
    const float under_v = below_v[i] - v[i], over_v = v[i] - above_v[i];
    const float under_z = below_z[i] - z[i], over_z = z[i] - above_z[i];
    const bool after = std::abs(after_z) < most, before = std::abs(before_z) < most;
    const bool under = std::abs(under_z) < most, over = std::abs(over_z) < most;
    const float xu = after ? after_u : before ? before_u : usual_u;
    const float xv = after ? after_v : before ? before_v : 0;
    const float xz = after ? after_z : before ? before_z : 0;
    const float yu = under ? under_u : over ? over_u : 0;
    const float yv = under ? under_v : over ? over_v : usual_v;
    const float yz = under ? under_z : over ? over_z : 0;

    const float determinant = xu * yv - yu * xv;
    const float inverse = std::abs(determinant) > 1e-3F ? 1 / determinant : 0;
    slope_u[i] = (xz * yv - yz * xv) * inverse;
    slope_v[i] = (yz * xu - xz * yu) * inverse;

    const float half_u = std::min(0.5F * (std::abs(xu) + std::abs(yu)), most_u);
    const float half_v = std::min(0.5F * (std::abs(xv) + std::abs(yv)), most_v);
    // A pixel without depth covers nothing: its last is before its first.
    const bool valid = z[i] > 0;
    const float left = valid ? u[i] - half_u : 1, right = valid ? u[i] + half_u : 0;
    const float top = valid ? v[i] - half_v : 1, bottom = valid ? v[i] + half_v : 0;
    first_u[i] = round_up(std::clamp(left, 0.F, right_most + 1));
    last_u[i] = round_down(std::clamp(right, -1.F, right_most));
    first_v[i] = round_up(std::clamp(top, 0.F, bottom_most + 1));
    last_v[i] = round_down(std::clamp(bottom, -1.F, bottom_most));
  }
}

// The nearest surface wins.
void draw(const ProjectedRow& row, const Footprints& footprints, cv::Mat_<float>& registered) {
  const std::size_t width = footprints.first_u.size();
  for (std::size_t i = 0; i < width; ++i) {
    const float u = row.u[i + 1], v = row.v[i + 1], z = row.z[i + 1];
    for (std::int32_t y = footprints.first_v[i]; y <= footprints.last_v[i]; ++y) {
      float* const line = registered[y];
      const float middle = z + footprints.slope_v[i] * (static_cast<float>(y) - v);
      for (std::int32_t x = footprints.first_u[i]; x <= footprints.last_u[i]; ++x) {
        const float here = middle + footprints.slope_u[i] * (static_cast<float>(x) - u);
        if (!(line[x] <= here)) line[x] = here;
      }
    }
  }
}

}  // namespace

DepthRegistration make_depth_registration(const DistortedCamera& depth,
                                          const DistortedCamera& colour,
                                          const SE3& colour_from_depth) {
  check("depth", depth.pinhole);
  check("colour", colour.pinhole);
  const cv::Size size(depth.pinhole.width, depth.pinhole.height);
  DepthRegistration registration{.depth = depth,
                                 .colour = colour,
                                 .ray_x = cv::Mat_<float>(size),
                                 .ray_y = cv::Mat_<float>(size),
                                 .ray_z = cv::Mat_<float>(size),
                                 .origin = colour_from_depth.translation.cast<float>(),
                                 .largest_radius = largest_radius(colour)};
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector3d ray = colour_from_depth.rotation * ray_of(depth, x, y).homogeneous();
      registration.ray_x(y, x) = static_cast<float>(ray.x());
      registration.ray_y(y, x) = static_cast<float>(ray.y());
      registration.ray_z(y, x) = static_cast<float>(ray.z());
    }
  return registration;
}

cv::Mat_<float> register_depth(const DepthRegistration& registration,
                               const cv::Mat_<float>& depth) {
  if (depth.size() != registration.ray_x.size())
    throw Error(ErrorCode::kInput,
                fmt::format("depth of {} x {} px, but the depth camera has {} x {} px", depth.cols,
                            depth.rows, registration.ray_x.cols, registration.ray_x.rows));
  const Camera& colour = registration.colour.pinhole;
  cv::Mat_<float> registered(colour.height, colour.width, kNone);
  const ProjectedRow empty(depth.cols);
  std::array<ProjectedRow, 3> rows = {empty, empty, empty};
  Footprints footprints(depth.cols);
  if (depth.rows > 0) project_row(registration, depth[0], 0, rows[0]);
  for (int y = 0; y < depth.rows; ++y) {
    const bool is_last = y + 1 == depth.rows;
    if (!is_last) project_row(registration, depth[y + 1], y + 1, rows[(y + 1) % 3]);
    const ProjectedRow& here = rows[y % 3];
    find_footprints(registration, y == 0 ? empty : rows[(y + 2) % 3], here,
                    is_last ? empty : rows[(y + 1) % 3], footprints);
    draw(here, footprints, registered);
  }
  return registered;
}

}  // namespace edvo
