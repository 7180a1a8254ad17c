// SPDX-License-Identifier: MIT
// The figures that the paper prints, to stand beside measured ones.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace edvo::app {

// K. Lu, J. Cheng, Y. Zhou, J. Deng, R. Fan, K. Luo: "Robust Edge-Direct Visual Odometry based on
// CNN edge detection and Shi-Tomasi corner optimization".
inline constexpr std::string_view kPaper = "Lu et al., Robust Edge-Direct Visual Odometry";

inline constexpr std::array<std::string_view, 4> kPaperColumns = {"ORB-SLAM2", "Origin",
                                                                  "Canny+Corner", "CNN+Corner"};

struct PaperFigures {
  std::optional<double> rpe_rotation;     // Table I, root mean square [deg/s]
  std::optional<double> rpe_translation;  // Table I, root mean square [m/s]
  std::optional<double> ate;              // Table II, root mean square [m]
};

struct PaperRow {
  std::string_view sequence;                               // as the benchmark names it
  std::string_view printed;                                // as the paper does
  std::array<PaperFigures, kPaperColumns.size()> systems;  // in the order of kPaperColumns
};

// By either of its names; null if the paper has no such sequence.
[[nodiscard]] const PaperRow* find_paper_row(std::string_view sequence);

}  // namespace edvo::app
