// SPDX-License-Identifier: MIT
// A disk that is full at the Nth write to a file: to be loaded before the C library (LD_PRELOAD) by
// scripts/soak.sh. Of that write the first half still fits; each one after it, and each fsync, fails.
//   FAIL_AT     which write fails, counted from 1
//   FAIL_WITH   its error number, ENOSPC if not set
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

static atomic_long writes;

static int number(const char* name, int otherwise) {
  const char* const text = getenv(name);
  return text ? atoi(text) : otherwise;
}

static int is_file(int descriptor) {
  struct stat status;
  return fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  static ssize_t (*real)(int, const void*, size_t);
  if (!real) real = (ssize_t(*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
  if (!is_file(descriptor)) return real(descriptor, bytes, size);
  const long n = atomic_fetch_add(&writes, 1) + 1;
  const long last = number("FAIL_AT", 1);
  if (n < last) return real(descriptor, bytes, size);
  if (n == last && size > 1) return real(descriptor, bytes, size / 2);
  errno = number("FAIL_WITH", ENOSPC);
  return -1;
}

int fsync(int descriptor) {
  static int (*real)(int);
  if (!real) real = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
  if (!is_file(descriptor) || atomic_load(&writes) < number("FAIL_AT", 1)) return real(descriptor);
  errno = number("FAIL_WITH", ENOSPC);
  return -1;
}
