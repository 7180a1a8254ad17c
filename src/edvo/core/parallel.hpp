// SPDX-License-Identifier: MIT
// A loop on several threads. Calls must not share results, so that the number of threads never
// shows in them.
#pragma once

#include <algorithm>
#include <functional>
#include <thread>
#include <vector>

namespace edvo {

// Calls function(i) for each i in [0..count); function must not throw.
inline void for_each_index(int count, int threads, const std::function<void(int)>& function) {
  const int step = std::max(1, std::min(threads, count));
  const auto work = [&](int first) {
    for (int i = first; i < count; i += step) function(i);
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < step; ++i) helpers.emplace_back(work, i);
  work(0);
}

}  // namespace edvo
