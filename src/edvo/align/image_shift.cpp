// SPDX-License-Identifier: MIT
#include "edvo/align/image_shift.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace edvo {
namespace {

constexpr int kAround = 2;  // [px] of the peak, that its centre is the mean of

// Magnitudes of a packed spectrum's numbers in place of their real parts; the imaginary ones stay
// zero. Complex pairs lie along the rows, but in the first column, and in the last if the width is
// even, down the column, after a real number and, if the height is even, before another.
void write_magnitudes(const cv::Mat_<float>& spectrum, cv::Mat_<float>& magnitudes) {
  const int rows = spectrum.rows, columns = spectrum.cols;
  const auto write = [&](cv::Point real, cv::Point imaginary) {
    const auto a = static_cast<double>(spectrum(real)),
               b = static_cast<double>(spectrum(imaginary));
    magnitudes(real) = static_cast<float>(std::sqrt(a * a + b * b));
  };
  for (int x = 0; x < columns; x += columns - 1) {
    if (x > 0 && columns % 2 != 0) break;
    magnitudes(0, x) = std::abs(spectrum(0, x));
    for (int y = 1; y + 1 < rows; y += 2) write({x, y}, {x, y + 1});
    if (rows % 2 == 0) magnitudes(rows - 1, x) = std::abs(spectrum(rows - 1, x));
  }
  for (int y = 0; y < rows; ++y)
    for (int x = 1; x + 1 < columns; x += 2) write({x, y}, {x + 1, y});
}

// Of a periodic image, from its upper left to the highest peak when all is moved by half its size,
// so that shifts of either sign lie around the middle.
cv::Point2d peak_of(const cv::Mat_<float>& image) {
  const int columns = image.cols, rows = image.rows;
  const auto at = [&](int x, int y) {
    return image((y + rows - rows / 2) % rows, (x + columns - columns / 2) % columns);
  };
  cv::Point peak;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      if (at(x, y) > at(peak.x, peak.y)) peak = {x, y};
  cv::Point2d sum;
  double weight = 0;
  for (int y = std::max(0, peak.y - kAround); y <= std::min(rows - 1, peak.y + kAround); ++y)
    for (int x = std::max(0, peak.x - kAround); x <= std::min(columns - 1, peak.x + kAround); ++x) {
      const auto value = static_cast<double>(at(x, y));
      sum += value * cv::Point2d(x, y);
      weight += value;
    }
  return sum / weight;
}

}  // namespace

void PhaseCorrelation::start(cv::Size size) {
  size_ = size;
  cv::createHanningWindow(window_, size, CV_32F);
  const cv::Size quick(cv::getOptimalDFTSize(size.width), cv::getOptimalDFTSize(size.height));
  for (cv::Mat_<float>* image :
       {&padded_, &spectrum_, &last_, &product_, &magnitudes_, &whitened_, &correlation_})
    *image = cv::Mat_<float>::zeros(quick);
  forward_ =
      cv::hal::DFT2D::create(quick.width, quick.height, CV_32F, 1, 1, CV_HAL_DFT_IS_CONTINUOUS);
  inverse_ = cv::hal::DFT2D::create(quick.width, quick.height, CV_32F, 1, 1,
                                    CV_HAL_DFT_IS_CONTINUOUS | CV_HAL_DFT_INVERSE);
}

void PhaseCorrelation::transform(const cv::Mat_<std::uint8_t>& image) {
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      padded_(y, x) = window_(y, x) * static_cast<float>(image(y, x));
  forward_->apply(padded_.data, padded_.step, spectrum_.data, spectrum_.step);
}

void PhaseCorrelation::set_reference(const cv::Mat_<std::uint8_t>& image) {
  if (image.size() != size_) start(image.size());
  if (image.data != transformed_.data) transform(image);
  std::swap(last_, spectrum_);
  transformed_ = {};
}

cv::Point2d PhaseCorrelation::shift_to(const cv::Mat_<std::uint8_t>& image) {
  if (image.size() != size_) return {};
  transform(image);
  transformed_ = image;
  cv::mulSpectrums(last_, spectrum_, product_, 0, true);
  write_magnitudes(product_, magnitudes_);
  cv::divSpectrums(product_, magnitudes_, whitened_, 0);
  inverse_->apply(whitened_.data, whitened_.step, correlation_.data, correlation_.step);
  const cv::Point2d shift =
      cv::Point2d(correlation_.cols / 2, correlation_.rows / 2) - peak_of(correlation_);
  return std::isfinite(shift.x) && std::isfinite(shift.y) ? shift : cv::Point2d();
}

SE3 rotation_from_image_shift(const cv::Point2d& shift, const Camera& camera) {
  const Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();  // is seen there now
  const Eigen::Vector3d there(shift.x / camera.fx, shift.y / camera.fy, 1);
  return {.rotation = Eigen::Quaterniond::FromTwoVectors(ahead, there), .translation = {0, 0, 0}};
}

}  // namespace edvo
