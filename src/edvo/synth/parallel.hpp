// SPDX-License-Identifier: MIT
// Row blocks on several threads. Blocks must not share results, so that the number of threads
// never shows in them.
#pragma once

#include <algorithm>
#include <thread>
#include <vector>

namespace edvo::synth {

// threads = 0: as many as the machine has.
[[nodiscard]] inline int thread_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

// Calls function(block) for each block in [0..blocks).
template <typename Function>
void for_each_block(int blocks, int threads, const Function& function) {
  const int count = std::min(thread_count(threads), blocks);
  const auto work = [&](int first) {
    for (int block = first; block < blocks; block += count) function(block);
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < count; ++i) helpers.emplace_back(work, i);
  work(0);
}

}  // namespace edvo::synth
