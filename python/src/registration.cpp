// SPDX-License-Identifier: MIT
// Depth of another camera, as the colour camera would have measured it.
#include "bindings.hpp"
#include "edvo/image/depth_registration.hpp"

namespace edvo::python {

void add_registration(nb::module_& module) {
  using namespace nb::literals;
  nb::class_<DepthRegistration>(module, "DepthRegistration")
      .def(
          "__init__",
          [](DepthRegistration* place, const CameraTuple& depth, const CameraTuple& colour,
             const nb::ndarray<const double, nb::shape<4, 4>, nb::c_contig>& colour_from_depth) {
            const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(
                colour_from_depth.data());
            const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
            new (place) DepthRegistration(
                make_depth_registration(to_camera(depth), to_camera(colour),
                                        {.rotation = Eigen::Quaterniond(rotation).normalized(),
                                         .translation = matrix.topRightCorner<3, 1>()}));
          },
          "depth"_a, "colour"_a, "colour_from_depth"_a)
      .def(
          "register",
          [](const DepthRegistration& registration, const MetreArray& depth) {
            cv::Mat_<float> registered;
            {
              const nb::gil_scoped_release release;
              registered = register_depth(registration, to_depth(depth));
            }
            return numpy_depth(registered);
          },
          "depth"_a);
}

}  // namespace edvo::python
