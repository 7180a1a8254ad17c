// SPDX-License-Identifier: MIT
// Which keyframes may show the same place: codes of whole images, compared with all others.
//
// Random ferns as in Glocker, Shotton, Criminisi, Izadi 2015 ("Real-time RGB-D camera
// relocalization via randomized ferns"), on rank-normalized grey and inverse depth so that
// brightness and exposure do not matter. No vocabulary, no learning; what is found does not depend
// on the order in which places were added.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace edvo {

constexpr int kFerns = 512;  // of four bits each: three tests of grey, one of inverse depth
using FernCode = std::array<std::uint8_t, kFerns / 2>;

// gray: H x W; depth: H x W, [m], NaN = none.
[[nodiscard]] FernCode make_fern_code(const cv::Mat_<std::uint8_t>& gray,
                                      const cv::Mat_<float>& depth);

// Share of ferns that are equal [0..1]; chance alone gives 1 / 16.
[[nodiscard]] double similarity(const FernCode& a, const FernCode& b);

struct PlaceMatch {
  std::int64_t id = 0;
  double similarity = 0;  // [0..1]
};

class PlaceIndex {
 public:
  void add(std::int64_t id, const FernCode& code);

  // The most similar places with ids below a limit, best first; of equals the lower id first.
  [[nodiscard]] std::vector<PlaceMatch> search(const FernCode& code, std::int64_t ids_below,
                                               std::size_t count) const;

  [[nodiscard]] std::size_t size() const { return ids_.size(); }

 private:
  std::vector<std::int64_t> ids_;
  std::vector<FernCode> codes_;
};

}  // namespace edvo
