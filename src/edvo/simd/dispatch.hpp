// SPDX-License-Identifier: MIT
// One binary for every x86-64: hot functions are compiled thrice and chosen at start
// (docs/adr/0005).
#pragma once

// ThreadSanitizer cannot run in what chooses a version, as it is not there yet.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define EDVO_NO_CLONES
#endif
#elif defined(__SANITIZE_THREAD__)
#define EDVO_NO_CLONES
#endif

// A function so marked must contain its loops itself (what it calls is compiled for the baseline).
// Without contraction and reassociation all versions give the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(EDVO_NO_CLONES)
#define EDVO_CLONES __attribute__((target_clones("default", "avx2", "arch=x86-64-v4")))
#else
#define EDVO_CLONES
#endif

// Before a loop whose arrays do not overlap: over many arrays it is not vectorized without this
// promise.
#if defined(__clang__)
#define EDVO_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define EDVO_INDEPENDENT _Pragma("GCC ivdep")
#else
#define EDVO_INDEPENDENT
#endif
