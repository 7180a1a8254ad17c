// SPDX-License-Identifier: MIT
// Places of many rooms or many desks, to walk through for a long time.
#pragma once

#include "edvo/synth/furniture.hpp"

namespace edvo::synth {

// What tells the rooms of a flat apart.
enum class Likeness {
  kNone,    // each is furnished in its own way
  kPoster,  // one poster: all else is the same, down to the pixels of textures
  kSame,    // nothing
};

// Six rooms on both sides of a corridor, with open doors. Of rooms that are alike the corridor's
// walls repeat as well, so that it looks alike both ways; its two ends differ.
void furnish_flat(Builder& builder, Likeness likeness);

// Equal desks on both sides of an aisle, 2 m apart.
void furnish_desk_rows(Builder& builder);

}  // namespace edvo::synth
