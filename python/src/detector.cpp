// SPDX-License-Identifier: MIT
// Edge detectors: networks, and those written in Python.
#include "bindings.hpp"
#include "edvo/features/edge_strength.hpp"
#include "edvo/network/edge_network.hpp"
#include "python_error.hpp"
#include "shared_object.hpp"

#include <algorithm>
#include <memory>

namespace edvo::python {
namespace {

// Asks an edvo.EdgeDetector, with the GIL, in whatever thread tracks.
class PythonStrength final : public EdgeStrength {
 public:
  explicit PythonStrength(const nb::object& detector) : detector_(share(detector)) {}

  [[nodiscard]] cv::Mat_<float> strength(const cv::Mat_<cv::Vec3b>& bgr) const override {
    cv::Mat_<float> result(bgr.rows, bgr.cols);
    const nb::gil_scoped_acquire gil;
    rethrow_python_errors(
        [&] {
          const nb::object given = detector_->attr("_strength")(numpy_rgb(bgr));
          const auto values = nb::cast<MetreArray>(given);  // its size was checked
          std::copy_n(values.data(), values.size(), result[0]);
        },
        ErrorCode::kModel);
    return result;
  }

 private:
  Shared detector_;
};

}  // namespace

std::unique_ptr<EdgeDetector> detector_of(const Config& config, const DistortedCamera& camera,
                                          const nb::object& own) {
  if (!own.is_none())
    return make_strength_detector(std::make_unique<PythonStrength>(own), config.network);
  if (config.edge.detector != Detector::kNetwork) return nullptr;
  const cv::Size size(camera.pinhole.width, camera.pinhole.height);
  return make_strength_detector(open_network(config.network, size), config.network);
}

}  // namespace edvo::python
