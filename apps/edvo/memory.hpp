// SPDX-License-Identifier: MIT
// What the C library does with freed memory, for programs that handle one image after the other.
#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#if defined(__GLIBC__)  // known after the first header of the C library
#include <malloc.h>
#include <sys/mman.h>
#endif

namespace edvo::app {

// The memory of one frame serves the next. By default large images go back to the system when they
// are freed, and every page of the next image is a page fault: a sixth of a run's time where faults
// are dear. For the same reason the start of the heap, where the keyframes kept will lie, asks for
// huge pages; what is never used of it takes no memory.
inline void keep_freed_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 32 << 20);   // [bytes] smaller ones come from the heap
  mallopt(M_TRIM_THRESHOLD, 128 << 20);  // [bytes] that may lie free at its end
  mallopt(M_TOP_PAD, 4 << 20);           // [bytes] that it grows by
  constexpr std::size_t kPiece = 24 << 20, kHugePage = 2 << 20;  // [bytes] fewer than those above
  std::array<void*, 4> pieces{};
  for (void*& piece : pieces) {
    piece = std::malloc(kPiece);
    if (piece == nullptr) continue;
    const auto start = reinterpret_cast<std::uintptr_t>(piece);
    const std::uintptr_t aligned = (start + kHugePage - 1) / kHugePage * kHugePage;
    // Advice: if the system does not take it, all is as before.
    (void)madvise(reinterpret_cast<void*>(aligned), start + kPiece - aligned, MADV_HUGEPAGE);
  }
  for (void* piece : pieces) std::free(piece);
#endif
}

}  // namespace edvo::app
