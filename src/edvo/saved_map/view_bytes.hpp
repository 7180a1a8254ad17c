// SPDX-License-Identifier: MIT
// A keyframe's images as bytes that compress well: each pixel as the difference from what its
// neighbours let expect (the predictor of JPEG-LS, ITU-T T.87). Nothing is rounded.
#pragma once

#include "edvo/core/camera.hpp"
#include "edvo/slam/place.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace edvo {

[[nodiscard]] std::string encode_view(const Place& view);

// None if the bytes are not those of a view by this camera: sizes, ranges and every point's pixel
// are checked. The stamp is not among the bytes.
[[nodiscard]] std::optional<Place> decode_view(std::string_view bytes, const Camera& camera);

}  // namespace edvo
