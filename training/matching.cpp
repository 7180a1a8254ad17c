// SPDX-License-Identifier: MIT
// The size of a maximum matching between the set pixels of two masks that lie within a radius.
// Compiled and called by benchmark.py: scipy's own matching takes 20 s on one pair of dense masks.
#include <algorithm>
#include <cstdint>
#include <vector>

namespace {

constexpr int kFree = -1;

struct Offset {
  int dx = 0, dy = 0;  // [px]
};

// Offsets of a disc, nearest first.
std::vector<Offset> disc(double radius) {
  std::vector<Offset> offsets;
  const int reach = static_cast<int>(radius);
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx)
      if (dx * dx + dy * dy <= radius * radius) offsets.push_back({dx, dy});
  std::stable_sort(offsets.begin(), offsets.end(), [](Offset a, Offset b) {
    return a.dx * a.dx + a.dy * a.dy < b.dx * b.dx + b.dy * b.dy;
  });
  return offsets;
}

}  // namespace

// found, truth: height x width, not 0 = set.
extern "C" int count_matches(const std::uint8_t* found, const std::uint8_t* truth, int height,
                             int width, double radius) {
  const std::vector<Offset> offsets = disc(radius);
  const int total = height * width;
  std::vector<int> partner_of_found(total, kFree), partner_of_truth(total, kFree);
  const auto neighbour = [&](int pixel, Offset o) {
    const int x = pixel % width + o.dx, y = pixel / width + o.dy;
    const bool inside = x >= 0 && x < width && y >= 0 && y < height;
    return inside && truth[y * width + x] ? y * width + x : kFree;
  };

  // Nearest first: most pixels are paired here.
  int matches = 0;
  for (const Offset o : offsets)
    for (int f = 0; f < total; ++f) {
      if (!found[f] || partner_of_found[f] != kFree) continue;
      const int t = neighbour(f, o);
      if (t == kFree || partner_of_truth[t] != kFree) continue;
      partner_of_found[f] = t;
      partner_of_truth[t] = f;
      ++matches;
    }

  // Augmenting paths, breadth first. What a search that failed has seen can never be part of a
  // later path, so its marks stay; those of a search that succeeded are taken back.
  std::vector<int> reached_from(total, kFree);  // of truth pixels: the found pixel before them
  std::vector<int> queue, seen;
  for (int start = 0; start < total; ++start) {
    if (!found[start] || partner_of_found[start] != kFree) continue;
    queue.assign(1, start);
    seen.clear();
    int end = kFree;
    for (std::size_t head = 0; head < queue.size() && end == kFree; ++head)
      for (const Offset o : offsets) {
        const int t = neighbour(queue[head], o);
        if (t == kFree || reached_from[t] != kFree) continue;
        reached_from[t] = queue[head];
        seen.push_back(t);
        if (partner_of_truth[t] == kFree) {
          end = t;
          break;
        }
        queue.push_back(partner_of_truth[t]);
      }
    if (end == kFree) continue;
    ++matches;
    while (end != kFree) {
      const int f = reached_from[end];
      const int next = partner_of_found[f];
      partner_of_found[f] = end;
      partner_of_truth[end] = f;
      end = next;
    }
    for (const int t : seen) reached_from[t] = kFree;
  }
  return matches;
}
