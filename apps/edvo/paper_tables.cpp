// SPDX-License-Identifier: MIT
#include "paper_tables.hpp"

namespace edvo::app {
namespace {

constexpr std::nullopt_t kNone = std::nullopt;  // "-": the system failed

// Tables I and II, digit by digit: rotation and translation of the one, then the other.
constexpr PaperRow kRows[] = {
    {"fr1/xyz",
     "fr1/xyz",
     {{{0.978583, 0.015260, 0.009436},
       {1.568226, 0.027317, 0.045409},
       {1.472533, 0.024445, 0.042076},
       {0.724896, 0.025371, 0.038506}}}},
    {"fr2/360_hemisphere",
     "fr2/360/hemhere",
     {{{1.145817, 0.127742, 0.229800},
       {2.872298, 0.390793, 0.920911},
       {kNone, kNone, kNone},
       {1.021171, 0.080454, 0.328613}}}},
    {"fr2/dishes",
     "fr2/dishes",
     {{{2.402205, 0.098421, 0.122247},
       {0.700566, 0.016443, 0.094776},
       {0.959770, 0.023250, 0.091492},
       {0.787372, 0.018816, 0.083078}}}},
    {"fr2/coke",
     "fr2/coke",
     {{{5.759803, 0.104471, 0.419077},
       {1.168573, 0.621661, 8.952361},
       {1.783891, 0.046894, 0.148833},
       {1.052839, 0.025705, 0.087646}}}},
    {"fr3/cabinet",
     "fr3/cabinet",
     {{{kNone, kNone, kNone},
       {4.200325, 0.129285, 0.389984},
       {4.214291, 0.110508, 0.447204},
       {3.462629, 0.081417, 0.443365}}}},
    {"fr3/large_cabinet",
     "fr3/large/cabinet",
     {{{0.805515, 0.051905, 0.090161},
       {2.483856, 0.271248, 0.346849},
       {1.747718, 0.169891, 0.267330},
       {0.718709, 0.048065, 0.117691}}}},
    {"fr3/structure_texture_far",
     "fr3/str/texture/far",
     {{{0.540715, 0.014733, 0.016497},
       {0.454445, 0.013473, 0.027270},
       {0.781303, 0.019318, 0.041634},
       {0.455929, 0.013280, 0.034999}}}},
    {"fr3/structure_notexture_far",
     "fr3/str/noture/far",
     {{{0.723704, 0.027528, 0.027106},
       {2.782048, 0.216976, 0.300592},
       {1.227557, 0.045992, 0.115235},
       {0.607414, 0.021371, 0.036792}}}},
};

}  // namespace

const PaperRow* find_paper_row(std::string_view sequence) {
  for (const PaperRow& row : kRows)
    if (sequence == row.sequence || sequence == row.printed) return &row;
  return nullptr;
}

}  // namespace edvo::app
