// SPDX-License-Identifier: MIT
// What the C library does with freed memory, for programs that handle one image after the other.
#pragma once

#include <cstdlib>
#if defined(__GLIBC__)  // known after the first header of the C library
#include <malloc.h>
#endif

namespace edvo::app {

// The memory of one frame serves the next. By default large images go back to the system when they
// are freed, and every page of the next image is a page fault: a sixth of a run's time where faults
// are dear.
inline void keep_freed_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 32 << 20);   // [bytes] smaller ones come from the heap
  mallopt(M_TRIM_THRESHOLD, 128 << 20);  // [bytes] that may lie free at its end
  mallopt(M_TOP_PAD, 4 << 20);           // [bytes] that it grows by
#endif
}

}  // namespace edvo::app
