// SPDX-License-Identifier: MIT
#pragma once

#include "edvo/core/random.hpp"

namespace edvo::synth {

using edvo::mix;
using edvo::Random;

}  // namespace edvo::synth
