// SPDX-License-Identifier: MIT
// The values that the steps of a plan read and write, and the memory that they lie in.
#pragma once

#include "edvo/network/onednn_plan.hpp"

#include <map>
#include <string>
#include <vector>

namespace edvo {

// Layouts of floats.
[[nodiscard]] dnnl::memory::desc plain_layout(const dnnl::memory::dims& dims);
[[nodiscard]] dnnl::memory::desc channels_last(const dnnl::memory::dims& dims);
[[nodiscard]] dnnl::memory::desc any_layout(const dnnl::memory::dims& dims);

// Memory for values. Steps run one after the other, so what no later step reads is written over.
class PlanBuffers {
 public:
  explicit PlanBuffers(dnnl::engine engine) : engine_(std::move(engine)) {}

  [[nodiscard]] dnnl::memory take(const dnnl::memory::desc& layout);
  void give_back(const dnnl::memory& used);

  // All that were ever taken.
  [[nodiscard]] std::vector<dnnl::memory> release() { return std::move(all_); }

 private:
  dnnl::engine engine_;
  std::vector<dnnl::memory> all_, free_;
};

// Values by their names in the graph. How often each will be read is said before the first step;
// after the last reading its memory is given back. Functions that need a step append it to the
// plan. Throws Error(kModel) where a value is asked for that nothing gives.
class PlanValues {
 public:
  explicit PlanValues(NetworkPlan& plan) : plan_(plan), buffers_(plan.engine) {}

  void expect_reading(const std::string& name) { ++uses_[name]; }
  [[nodiscard]] bool is_read(const std::string& name) const { return uses_.contains(name); }
  [[nodiscard]] bool is_read_once(const std::string& name) const;  // more

  void put(const std::string& name, const dnnl::memory& value) { values_[name] = {value, {}}; }
  [[nodiscard]] bool contains(const std::string& name) const { return values_.contains(name); }
  [[nodiscard]] const dnnl::memory& at(const std::string& name) const;
  [[nodiscard]] dnnl::memory::dims dims_of(const std::string& name) const;

  // The value as it is or, once for all who ask, as a copy.
  [[nodiscard]] dnnl::memory in_layout(const std::string& name, const dnnl::memory::desc& layout);

  // The value in a ring of zeros, so many pixels wide: oneDNN's Winograd knows one pixel of border.
  [[nodiscard]] dnnl::memory in_ring(const std::string& name, dnnl::memory::dim ring,
                                     const dnnl::memory::desc& layout);

  // The value's memory, to be added to and written over; a copy where others will read it. Counts
  // as a reading.
  [[nodiscard]] dnnl::memory to_add_to(const std::string& name, const dnnl::memory::desc& layout);

  // It has been read once more.
  void release(const std::string& name);

  // Constants are brought into their layout once, now.
  [[nodiscard]] dnnl::memory stored(const std::vector<float>& numbers,
                                    const dnnl::memory::dims& dims,
                                    const dnnl::memory::desc& layout);

  void reorder(const dnnl::memory& from, const dnnl::memory& to);

  [[nodiscard]] PlanBuffers& buffers() { return buffers_; }

 private:
  struct Value {
    dnnl::memory memory;
    std::vector<dnnl::memory> copies;  // in other layouts
  };

  [[nodiscard]] const Value& find(const std::string& name) const;

  NetworkPlan& plan_;
  PlanBuffers buffers_;
  std::map<std::string, int> uses_;  // by steps to come
  std::map<std::string, Value> values_;
};

}  // namespace edvo
