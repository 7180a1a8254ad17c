// SPDX-License-Identifier: MIT
// A Python source as the loop's source of frames.
#pragma once

#include "bindings.hpp"
#include "edvo/source/rgbd_source.hpp"
#include "shared_object.hpp"

#include <cstdint>
#include <functional>
#include <memory>

namespace edvo::python {

// Which frames of a source; max_frames 0 = all.
struct FrameRange {
  std::int64_t first = 0;
  std::int64_t max_frames = 0;
};

// source: an edvo.Source, which is kept alive. Folders are read by the C++ library without Python;
// frames of others are asked for by whatever thread reads, one at a time, and copied before the
// next one is asked for. should_stop: true ends the wait for a frame of a source of someone else's.
// failure: where to put what the source raises, if it does; must live longer. Call it with the GIL;
// the result needs none, also when it is destroyed.
[[nodiscard]] std::unique_ptr<RgbdSource> make_source(const nb::object& source,
                                                      const FrameRange& range,
                                                      std::function<bool()> should_stop,
                                                      Shared* failure = nullptr);

void add_source(nb::module_& module);

}  // namespace edvo::python
