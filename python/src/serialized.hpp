// SPDX-License-Identifier: MIT
// An object that several Python threads may use: one call at a time.
#pragma once

#include "edvo/core/error.hpp"

#include <nanobind/nanobind.h>

#include <atomic>
#include <mutex>
#include <thread>
#include <utility>

namespace edvo::python {

template <typename T>
class Serialized {
 public:
  explicit Serialized(T object) : object_(std::move(object)) {}
  ~Serialized() = default;
  Serialized(const Serialized&) = delete;
  Serialized& operator=(const Serialized&) = delete;

  // What use(object) returns. Call it with the GIL, which is let go while it waits and works: the
  // call that is waited for may need it, for a detector written in Python. Throws Error(kUsage) if
  // that detector calls the object that asked it, which would wait for itself.
  template <typename Use>
  auto call(const Use& use) {
    const nanobind::gil_scoped_release release;
    const auto caller = std::this_thread::get_id();
    if (caller == user_)
      throw Error(ErrorCode::kUsage,
                  "called by its own detector: an Odometry or Slam that is at work can do nothing "
                  "else meanwhile");
    const std::lock_guard lock(mutex_);  // given back before the GIL is asked for
    const User user(user_, caller);
    return use(object_);
  }

 private:
  // Notes who works, as long as it does.
  class User {
   public:
    User(std::atomic<std::thread::id>& place, std::thread::id id) : place_(place) { place_ = id; }
    ~User() { place_ = std::thread::id{}; }
    User(const User&) = delete;
    User& operator=(const User&) = delete;

   private:
    std::atomic<std::thread::id>& place_;
  };

  T object_;
  std::mutex mutex_;  // of the object
  std::atomic<std::thread::id> user_;
};

}  // namespace edvo::python
