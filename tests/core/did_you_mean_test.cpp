// SPDX-License-Identifier: MIT
#include "edvo/core/did_you_mean.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace edvo {
namespace {

const std::vector<std::string> kWords = {"track.levels", "track.prior", "frame.levels", "run"};

TEST(DidYouMean, NamesTheNearestWord) {
  EXPECT_EQ(did_you_mean("trak.levels", kWords), ", did you mean 'track.levels'?");
  EXPECT_EQ(did_you_mean("frame.level", kWords), ", did you mean 'frame.levels'?");
}

TEST(DidYouMean, TakesTwoSwappedLettersForOneSlip) {
  EXPECT_EQ(did_you_mean("rnu", kWords), ", did you mean 'run'?");
}

TEST(DidYouMean, IsSilentWhereNothingIsNear) {
  EXPECT_EQ(did_you_mean("colour", kWords), "");
  EXPECT_EQ(did_you_mean("", kWords), "");
  EXPECT_EQ(did_you_mean("run", {}), "");
}

}  // namespace
}  // namespace edvo
