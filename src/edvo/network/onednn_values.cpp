// SPDX-License-Identifier: MIT
#include "edvo/network/onednn_values.hpp"

#include "edvo/network/onednn_version.hpp"

#include "edvo/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace edvo {
namespace {

using dnnl::memory;
using Layout = memory::format_tag;

constexpr auto kFloat = memory::data_type::f32;

std::size_t size_of(const memory& buffer) {
  return buffer.get_desc().get_size();
}

}  // namespace

memory::desc plain_layout(const memory::dims& dims) {
  constexpr std::array kLayouts = {Layout::a, Layout::ab, Layout::abc, Layout::abcd, Layout::abcde};
  return {dims, kFloat, kLayouts.at(dims.size() - 1)};
}

memory::desc channels_last(const memory::dims& dims) {
  return {dims, kFloat, Layout::acdb};
}

memory::desc any_layout(const memory::dims& dims) {
  return {dims, kFloat, Layout::any};
}

memory PlanBuffers::take(const memory::desc& layout) {
  const std::size_t bytes = layout.get_size();
  auto best = free_.end();  // of equal ones the last given back: the cache may still hold it
  for (auto it = free_.begin(); it != free_.end(); ++it)
    if (size_of(*it) >= bytes && (best == free_.end() || size_of(*it) <= size_of(*best))) best = it;
  if (best == free_.end()) {
    const memory::desc flat({static_cast<memory::dim>(bytes)}, memory::data_type::u8, Layout::a);
    all_.emplace_back(flat, engine_);
    return {layout, engine_, all_.back().get_data_handle()};
  }
  const memory taken(layout, engine_, best->get_data_handle());
  free_.erase(best);
  return taken;
}

void PlanBuffers::give_back(const memory& used) {
  // A lambda: with oneDNN 3 the member is one of several of this name.
  free_.push_back(*std::ranges::find_if(all_, [&](const memory& other) {
    return other.get_data_handle() == used.get_data_handle();
  }));
}

bool PlanValues::is_read_once(const std::string& name) const {
  const auto uses = uses_.find(name);
  return uses != uses_.end() && uses->second == 1;
}

const PlanValues::Value& PlanValues::find(const std::string& name) const {
  const auto found = values_.find(name);
  if (found == values_.end())
    throw Error(ErrorCode::kModel, fmt::format("'{}', which nothing gives", name));
  return found->second;
}

const memory& PlanValues::at(const std::string& name) const {
  return find(name).memory;
}

memory::dims PlanValues::dims_of(const std::string& name) const {
  return edvo::dims_of(at(name).get_desc());
}

memory PlanValues::in_layout(const std::string& name, const memory::desc& layout) {
  (void)find(name);
  Value& value = values_.at(name);
  if (value.memory.get_desc() == layout) return value.memory;
  for (const memory& copy : value.copies)
    if (copy.get_desc() == layout) return copy;
  const memory copy = buffers_.take(layout);
  reorder(value.memory, copy);
  value.copies.push_back(copy);
  return copy;
}

memory PlanValues::in_ring(const std::string& name, memory::dim ring, const memory::desc& layout) {
  if (ring == 0) return in_layout(name, layout);
  const memory around(layout, plan_.engine);  // not from what others write over
  std::memset(around.get_data_handle(), 0, layout.get_size());
  const memory::desc inner = layout.submemory_desc(dims_of(name), {0, 0, ring, ring});
  const memory inside(inner, plan_.engine, around.get_data_handle());
  reorder(at(name), inside);
  return around;
}

memory PlanValues::to_add_to(const std::string& name, const memory::desc& layout) {
  const memory own = at(name);
  if (is_read_once(name) && own.get_desc() == layout) {
    for (const memory& copy : find(name).copies) buffers_.give_back(copy);
    values_.erase(name);
    return own;
  }
  const memory copy = buffers_.take(layout);
  reorder(own, copy);
  release(name);
  return copy;
}

void PlanValues::release(const std::string& name) {
  if (--uses_[name] > 0) return;
  const Value& value = values_.at(name);
  buffers_.give_back(value.memory);
  for (const memory& copy : value.copies) buffers_.give_back(copy);
  values_.erase(name);
}

memory PlanValues::stored(const std::vector<float>& numbers, const memory::dims& dims,
                          const memory::desc& layout) {
  std::vector<float> source = numbers;
  memory before(plain_layout(dims), plan_.engine, source.data());
  memory after(layout, plan_.engine);
  dnnl::reorder(before, after).execute(plan_.stream, before, after);
  plan_.stream.wait();
  return after;
}

void PlanValues::reorder(const memory& from, const memory& to) {
  plan_.steps.push_back({dnnl::reorder(from, to), {{DNNL_ARG_FROM, from}, {DNNL_ARG_TO, to}}});
}

}  // namespace edvo
