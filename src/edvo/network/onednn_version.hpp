// SPDX-License-Identifier: MIT
// oneDNN 2 (Debian 12) and 3 (Debian 13) differ in how a primitive is described; the callers do
// not.
#pragma once

#include <dnnl.hpp>
#include <utility>

namespace edvo {

enum class IfUnknown { kThrow, kLeaveEmpty };  // what happens where oneDNN has no implementation

// The primitive that `told` describes: propagation, algorithm, layouts and sizes, in oneDNN's
// order.
template <typename Primitive, typename... Told>
[[nodiscard]] typename Primitive::primitive_desc described(const dnnl::engine& engine,
                                                           const dnnl::primitive_attr& attributes,
                                                           IfUnknown if_unknown, Told&&... told) {
  const bool may_be_empty = if_unknown == IfUnknown::kLeaveEmpty;
#if DNNL_VERSION_MAJOR >= 3
  return {engine, std::forward<Told>(told)..., attributes, may_be_empty};
#else
  return {typename Primitive::desc(std::forward<Told>(told)...), attributes, engine, may_be_empty};
#endif
}

inline void append_function(dnnl::post_ops& operators, dnnl::algorithm kind, float alpha,
                            float beta) {
#if DNNL_VERSION_MAJOR >= 3
  operators.append_eltwise(kind, alpha, beta);
#else
  operators.append_eltwise(1, kind, alpha, beta);
#endif
}

// A function of each number of a value.
[[nodiscard]] inline dnnl::eltwise_forward::primitive_desc described_function(
    const dnnl::engine& engine, dnnl::algorithm kind, const dnnl::memory::desc& layout, float alpha,
    float beta) {
#if DNNL_VERSION_MAJOR >= 3
  return {engine, dnnl::prop_kind::forward_inference, kind, layout, layout, alpha, beta};
#else
  return {{dnnl::prop_kind::forward_inference, kind, layout, alpha, beta}, engine};
#endif
}

// The largest number of each window.
[[nodiscard]] inline dnnl::pooling_forward::primitive_desc described_maximum(
    const dnnl::engine& engine, const dnnl::memory::desc& source, const dnnl::memory::desc& target,
    const dnnl::memory::dims& strides, const dnnl::memory::dims& kernel,
    const dnnl::memory::dims& before, const dnnl::memory::dims& after) {
  constexpr auto kInference = dnnl::prop_kind::forward_inference;
  constexpr auto kMaximum = dnnl::algorithm::pooling_max;
#if DNNL_VERSION_MAJOR >= 3
  const dnnl::memory::dims no_dilation(kernel.size(), 0);
  return {engine,  kInference, kMaximum,    source, target,
          strides, kernel,     no_dilation, before, after};
#else
  return {{kInference, kMaximum, source, target, strides, kernel, before, after}, engine};
#endif
}

[[nodiscard]] inline dnnl::memory::dims dims_of(const dnnl::memory::desc& layout) {
#if DNNL_VERSION_MAJOR >= 3
  return layout.get_dims();
#else
  return layout.dims();
#endif
}

}  // namespace edvo
