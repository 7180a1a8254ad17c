// SPDX-License-Identifier: MIT
#include "edvo/io/model_catalogue.hpp"

#include <algorithm>
#include <array>

namespace edvo {
namespace {

// The zoo keeps the file with Git LFS: raw.githubusercontent.com has only a pointer to it, and
// github.com/.../raw/... leads here. The second is the zoo's own mirror.
constexpr std::array<std::string_view, 2> kDexinedAddresses = {
    "https://media.githubusercontent.com/media/opencv/opencv_zoo/main/models/"
    "edge_detection_dexined/edge_detection_dexined_2024sep.onnx",
    "https://huggingface.co/opencv/edge_detection_dexined/resolve/main/"
    "edge_detection_dexined_2024sep.onnx"};

// DexiNed subtracts these means from BGR, halves the image four times, and gives six side maps and
// last the fused one, all before the sigmoid.
constexpr std::string_view kDexinedUsage = R"([input]
channels = "bgr"
mean = [103.939, 116.779, 123.68]
scale = 1.0
multiple_of = 16
padding = "reflect"

[output]
index = -1
activation = "sigmoid"
)";

constexpr std::array kKnown = {
    KnownModel{.name = "dexined",
               .addresses = kDexinedAddresses,
               .bytes = 47'235'563,
               .sha256 = "a50d01dc8481549c7dedb9eb3e0123b810a016520df75e4669a504609982cdd0",
               .licence = "MIT",
               .source = "OpenCV zoo, edge_detection_dexined_2024sep: DexiNed by X. Soria et al., "
                         "trained on BIPED, weights in 8-bit blocks",
               .usage = kDexinedUsage}};

}  // namespace

std::span<const KnownModel> known_models() {
  return kKnown;
}

const KnownModel* find_known_model(std::string_view name) {
  const auto found = std::ranges::find(kKnown, name, &KnownModel::name);
  return found == kKnown.end() ? nullptr : &*found;
}

}  // namespace edvo
