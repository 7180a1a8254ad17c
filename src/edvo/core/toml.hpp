// SPDX-License-Identifier: MIT
// toml++ for texts that anyone may have written. It asserts what damaged ones do not hold ("[....")
// right before it checks and reports the same. Such a text must not end a debug build, nor mislead
// the optimizer of clang, which is told with NDEBUG that the assertions hold.
#pragma once

#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(expression) static_assert(true)
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")
