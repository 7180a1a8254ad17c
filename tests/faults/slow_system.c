// SPDX-License-Identifier: MIT
// A file system that stalls, reads and writes less than asked, and is interrupted, and a clock that
// jumps: to be loaded before the C library (LD_PRELOAD) by scripts/soak.sh. Only regular files.
//   STALL_EVERY, STALL_MS     each Nth open, read, write and fsync takes so long [ms]
//   SHORT_BYTES               no read or write is of more than so many bytes
//   INTERRUPT_EVERY           each Nth read and write ends with EINTR, nothing done
//   CLOCK_JUMP                the time of day jumps to and fro by so much [s] at each question
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static atomic_long calls, transfers, questions;

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static long number(const char* name) {
  const char* const text = getenv(name);
  return text ? atol(text) : 0;
}

static int is_file(int descriptor) {
  struct stat status;
  return fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

static void stall(void) {
  const long every = number("STALL_EVERY"), ms = number("STALL_MS");
  if (every == 0 || (atomic_fetch_add(&calls, 1) + 1) % every != 0) return;
  const struct timespec pause = {ms / 1000, (ms % 1000) * 1000000};
  const int error = errno;
  nanosleep(&pause, NULL);
  errno = error;
}

static int is_interrupted(void) {
  const long every = number("INTERRUPT_EVERY");
  return every > 0 && (atomic_fetch_add(&transfers, 1) + 1) % every == 0;
}

static size_t shortened(size_t size) {
  const long most = number("SHORT_BYTES");
  return most > 0 && size > (size_t)most ? (size_t)most : size;
}

ssize_t read(int descriptor, void* bytes, size_t size) {
  if (!is_file(descriptor)) return REAL(read)(descriptor, bytes, size);
  stall();
  if (is_interrupted()) {
    errno = EINTR;
    return -1;
  }
  return REAL(read)(descriptor, bytes, shortened(size));
}

ssize_t write(int descriptor, const void* bytes, size_t size) {
  if (!is_file(descriptor)) return REAL(write)(descriptor, bytes, size);
  stall();
  if (is_interrupted()) {
    errno = EINTR;
    return -1;
  }
  return REAL(write)(descriptor, bytes, shortened(size));
}

int fsync(int descriptor) {
  stall();
  return REAL(fsync)(descriptor);
}

static int open_slowly(__typeof__(&open) real, const char* path, int flags, mode_t mode) {
  stall();
  return real(path, flags, mode);
}

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_slowly(REAL(open), path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_slowly(REAL(open64), path, flags, mode);
}

static time_t jump(void) {
  return number("CLOCK_JUMP") * (atomic_fetch_add(&questions, 1) % 3 - 1);
}

int clock_gettime(clockid_t clock, struct timespec* now) {
  const int status = REAL(clock_gettime)(clock, now);
  if (clock == CLOCK_REALTIME && status == 0) now->tv_sec += jump();
  return status;
}

int gettimeofday(struct timeval* restrict now, void* restrict zone) {
  const int status = REAL(gettimeofday)(now, zone);
  if (status == 0) now->tv_sec += jump();
  return status;
}

time_t time(time_t* now) {
  const time_t seconds = REAL(time)(NULL) + jump();
  if (now) *now = seconds;
  return seconds;
}
