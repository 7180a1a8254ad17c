// SPDX-License-Identifier: MIT
#include "edvo/network/onednn_plan.hpp"

#include "edvo/core/error.hpp"
#include "edvo/network/convolution_window.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <ranges>
#include <set>

namespace edvo {
namespace {

using dnnl::algorithm;
using dnnl::memory;
using Dims = memory::dims;
using Layout = memory::format_tag;

constexpr auto kFloat = memory::data_type::f32;
constexpr auto kInference = dnnl::prop_kind::forward_inference;

[[noreturn]] void fail(const std::string& reason) {
  throw Error(ErrorCode::kModel, reason);
}

Dims dims(Sides sides) {
  return {sides.y, sides.x};
}

memory::desc plain(const Dims& dims) {
  constexpr std::array kLayouts = {Layout::a, Layout::ab, Layout::abc, Layout::abcd, Layout::abcde};
  return {dims, kFloat, kLayouts.at(dims.size() - 1)};
}

memory::desc channels_last(const Dims& dims) {
  return {dims, kFloat, Layout::acdb};
}

memory::desc any_layout(const Dims& dims) {
  return {dims, kFloat, Layout::any};
}

// Memory for values. Steps run one after the other, so what no later step reads is written over.
class Buffers {
 public:
  explicit Buffers(dnnl::engine engine) : engine_(std::move(engine)) {}

  memory take(const memory::desc& layout) {
    const std::size_t bytes = layout.get_size();
    auto best = free_.end();  // of equal ones the last given back: the cache may still hold it
    for (auto it = free_.begin(); it != free_.end(); ++it)
      if (size_of(*it) >= bytes && (best == free_.end() || size_of(*it) <= size_of(*best)))
        best = it;
    if (best == free_.end()) {
      const memory::desc flat({static_cast<memory::dim>(bytes)}, memory::data_type::u8, Layout::a);
      all_.emplace_back(flat, engine_);
      return {layout, engine_, all_.back().get_data_handle()};
    }
    const memory taken(layout, engine_, best->get_data_handle());
    free_.erase(best);
    return taken;
  }

  void give_back(const memory& used) {
    free_.push_back(*std::ranges::find(all_, used.get_data_handle(), &memory::get_data_handle));
  }

  [[nodiscard]] std::vector<memory> release() { return std::move(all_); }

 private:
  static std::size_t size_of(const memory& buffer) { return buffer.get_desc().get_size(); }

  dnnl::engine engine_;
  std::vector<memory> all_, free_;
};

// Turns a graph's nodes into steps, in their order.
class Planner {
 public:
  Planner(const OnnxGraph& graph, const std::string& output, const Dims& image) : graph_(graph) {
    plan_.image = image;
    ++uses_[output];
    ++uses_[graph.image];  // its memory takes the next image, too
    for (auto node = graph.nodes.rbegin(); node != graph.nodes.rend(); ++node)
      if (is_used(*node))
        for (const std::string& input : node->inputs) ++uses_[input];
    plan_.input = buffers_.take(channels_last(image));
    values_[graph.image] = {.memory = plan_.input, .copies = {}};
    for (std::size_t i = 0; i < graph.nodes.size(); ++i)
      if (is_used(graph.nodes[i]) && !fused_.contains(i)) add(i);
    plan_.output = in_layout(output, plain(dims_of(output)));
  }

  [[nodiscard]] NetworkPlan take() {
    plan_.buffers = buffers_.release();
    return std::move(plan_);
  }

 private:
  using Arguments = std::unordered_map<int, memory>;

  struct Value {
    dnnl::memory memory;
    std::vector<dnnl::memory> copies;  // in other layouts
  };

  struct Function {
    algorithm kind = algorithm::undef;
    float alpha = 0, beta = 0;
  };

  // oneDNN's Winograd knows nothing but Relu.
  enum class Fusible { kRelu, kFunctions, kAll };

  // What a primitive does to each of its sums before it writes it.
  struct Fused {
    std::string output;  // of the last
    std::string added;   // first another value is added, empty = none
    std::vector<Function> functions;
  };

  static Fused alone(const OnnxNode& node) {
    return {.output = node.outputs[0], .added = {}, .functions = {}};
  }

  [[nodiscard]] bool is_used(const OnnxNode& node) const {
    return std::ranges::any_of(node.outputs,
                               [this](const std::string& name) { return uses_.contains(name); });
  }

  void add(std::size_t i) {
    const OnnxNode& node = graph_.nodes[i];
    if (node.outputs.size() != 1 || node.inputs.empty())
      fail(fmt::format("{} with {} outputs", node.type, node.outputs.size()));
    if (const auto function = function_of(node))
      add_function(node, *function);
    else if (node.type == "Conv")
      add_convolution(i);
    else if (node.type == "ConvTranspose")
      add_enlargement(i);
    else if (node.type == "Add")
      add_binary(i, algorithm::binary_add);
    else if (node.type == "Sub")
      add_binary(i, algorithm::binary_sub);
    else if (node.type == "Mul")
      add_binary(i, algorithm::binary_mul);
    else if (node.type == "Div")
      add_binary(i, algorithm::binary_div);
    else if (node.type == "MaxPool")
      add_pooling(node);
    else if (node.type == "Concat")
      add_concatenation(node);
    else if (node.type == "Resize")
      add_resize(i);
    else
      fail(fmt::format("the operator {}", node.type));
  }

  void add_convolution(std::size_t i) {
    const OnnxNode& node = graph_.nodes[i];
    const Dims source = dims_of(node.inputs[0]);
    const OnnxTensor& kernel = constant(node.inputs.at(1));
    const memory::dim groups = integer(node, "group").value_or(1);
    const KernelWindow window = window_of(node, kernel);
    if (groups < 1 || kernel.dims[0] % groups != 0 || kernel.dims[1] * groups != source[1])
      fail("Conv whose weights do not fit its input");
    Dims weights = kernel.dims;
    if (groups > 1) {
      weights[0] /= groups;
      weights.insert(weights.begin(), groups);
    }
    const Sides size = window.output_size({source[2], source[3]});
    const Dims target = {1, kernel.dims[0], size.y, size.x};
    const Fused fused =
        fuse(i, target, suits_winograd(weights, window) ? Fusible::kRelu : Fusible::kAll);
    convolve(node.inputs[0], weights, floats_of(kernel), bias_of(node, target[1]), window,
             any_layout(target), fused);
  }

  void add_enlargement(std::size_t i) {
    const OnnxNode& node = graph_.nodes[i];
    const Dims source = dims_of(node.inputs[0]);
    const OnnxTensor& kernel = constant(node.inputs.at(1));
    const KernelWindow transposed = window_of(node, kernel);
    if (kernel.dims[0] != source[1]) fail("ConvTranspose whose weights do not fit its input");
    const Enlargement by = enlargement_of(node, transposed);
    const memory::dim s = by.factor, K = by.window.kernel.y, outputs = kernel.dims[1];
    const memory::dim height = s * source[2], width = s * source[3];
    const Sides places = by.window.output_size({source[2], source[3]});
    std::vector<float> bias;
    for (memory::dim r = 0; r < s * s; ++r)
      std::ranges::copy(bias_of(node, outputs), std::back_inserter(bias));
    Fused fused = fuse(i, {1, outputs, height, width}, Fusible::kFunctions);
    const std::string result = std::exchange(fused.output, fused.output + " before it is spread");
    uses_[fused.output] = 1;
    convolve(node.inputs[0], {s * s * outputs, source[1], K, K}, spread_weights(kernel, by), bias,
             by.window, channels_last({1, s * s * outputs, places.y, places.x}), fused);
    // Both as height x s x width x s x channels.
    const Dims sides = {places.y, s, places.x, s, outputs};
    const memory::dim row = places.x * s * s * outputs;
    const memory::desc from(sides, kFloat, {row, s * outputs, s * s * outputs, outputs, 1});
    const memory::desc to(sides, kFloat, {row, places.x * s * outputs, s * outputs, outputs, 1});
    const memory::desc spread = channels_last({1, outputs, s * places.y, s * places.x});
    memory all = buffers_.take(spread);
    const memory packed = values_.at(fused.output).memory;
    reorder({from, plan_.engine, packed.get_data_handle()},
            {to, plan_.engine, all.get_data_handle()});
    release(fused.output);
    if (by.margin > 0) {
      const Dims inner = {1, outputs, height, width};
      const memory cut = buffers_.take(channels_last(inner));
      reorder({spread.submemory_desc(inner, {0, 0, by.margin, by.margin}), plan_.engine,
               all.get_data_handle()},
              cut);
      buffers_.give_back(std::exchange(all, cut));
    }
    values_[result] = {.memory = all, .copies = {}};
  }

  void convolve(const std::string& input, const Dims& weights, const std::vector<float>& kernel,
                const std::vector<float>& bias, const KernelWindow& window,
                const memory::desc& target, const Fused& fused) {
    const Dims bias_dims = {static_cast<memory::dim>(bias.size())};
    const auto description = [&](algorithm way, const memory::desc& from, const memory::desc& to,
                                 Sides before, Sides after) {
      return dnnl::convolution_forward::desc(kInference, way, from, any_layout(weights),
                                             any_layout(bias_dims), to, dims(window.stride),
                                             Dims{window.dilation.y - 1, window.dilation.x - 1},
                                             dims(before), dims(after));
    };
    const auto finish_with = [&](const dnnl::convolution_forward::primitive_desc& chosen,
                                 const memory& source) {
      finish(dnnl::convolution_forward(chosen),
             {{DNNL_ARG_SRC, source},
              {DNNL_ARG_WEIGHTS, stored(kernel, weights, chosen.weights_desc())},
              {DNNL_ARG_BIAS, stored(bias, bias_dims, chosen.bias_desc())}},
             chosen.dst_desc(), {input}, fused, chosen.scratchpad_desc());
    };
    const dnnl::primitive_attr attributes = attributes_of(fused);
    if (suits_winograd(weights, window)) {
      const memory::dim ring = std::max<memory::dim>(0, window.before.y - 1);
      const Sides border = {window.before.y - ring, window.before.x - ring};
      Dims source = dims_of(input);
      for (const std::size_t side : {2, 3}) source[side] += 2 * ring;
      const dnnl::convolution_forward::primitive_desc chosen(
          description(algorithm::convolution_winograd, any_layout(source), target, border, border),
          attributes, plan_.engine, true);
      if (chosen.get(true) != nullptr)
        return finish_with(chosen, ringed(input, ring, chosen.src_desc()));
    }
    // Layouts are those of the fastest implementation; operators fused to it may not change them.
    const dnnl::convolution_forward::primitive_desc fastest(
        description(algorithm::convolution_direct, any_layout(dims_of(input)), target,
                    window.before, window.after),
        plan_.engine);
    const dnnl::convolution_forward::primitive_desc chosen(
        description(algorithm::convolution_direct, fastest.src_desc(), fastest.dst_desc(),
                    window.before, window.after),
        attributes, plan_.engine);
    finish_with(chosen, in_layout(input, chosen.src_desc()));
  }

  // Winograd's way takes a quarter of the products, but more memory: from 64 channels on it is two
  // to three times as fast.
  static bool suits_winograd(const Dims& weights, const KernelWindow& window) {
    constexpr memory::dim kChannels = 64;
    return weights.size() == 4 && weights[0] >= kChannels && weights[1] >= kChannels &&
           window.kernel == Sides{3, 3} && window.stride == Sides{1, 1} &&
           window.dilation == Sides{1, 1} && window.before == window.after &&
           window.before.y == window.before.x;
  }

  // The value in a ring of zeros, so many pixels wide: oneDNN's Winograd knows one pixel of border.
  memory ringed(const std::string& name, memory::dim ring, const memory::desc& layout) {
    if (ring == 0) return in_layout(name, layout);
    const memory around(layout, plan_.engine);  // not from what others write over
    std::memset(around.get_data_handle(), 0, layout.get_size());
    const memory::desc inner = layout.submemory_desc(dims_of(name), {0, 0, ring, ring});
    const memory inside(inner, plan_.engine, around.get_data_handle());
    reorder(values_of(name).memory, inside);
    return around;
  }

  void add_function(const OnnxNode& node, const Function& function) {
    const std::string& input = node.inputs[the_number(node.inputs[0]) ? 1 : 0];
    const memory source = values_of(input).memory;
    const dnnl::eltwise_forward::primitive_desc chosen(
        {kInference, function.kind, source.get_desc(), function.alpha, function.beta},
        plan_.engine);
    finish(dnnl::eltwise_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(), {input},
           alone(node));
  }

  void add_binary(std::size_t i, algorithm kind) {
    const OnnxNode& node = graph_.nodes[i];
    std::string first = node.inputs[0], second = node.inputs.at(1);
    const bool commutes = kind == algorithm::binary_add || kind == algorithm::binary_mul;
    if (commutes && graph_.constants.contains(first)) std::swap(first, second);
    const memory source = values_of(first).memory;
    std::vector<std::string> used = {first};
    memory other;
    if (const auto found = graph_.constants.find(second); found != graph_.constants.end()) {
      const Dims dims = per_channel(found->second, dims_of(first)[1]);
      other = stored(floats_of(found->second), dims, plain(dims));
    } else {
      if (dims_of(second) != dims_of(first)) fail(fmt::format("{} of two sizes", node.type));
      other = in_layout(second, source.get_desc());
      used.push_back(second);
    }
    const Fused fused = fuse(i, dims_of(first), Fusible::kFunctions);
    const dnnl::binary::primitive_desc chosen(
        {kind, source.get_desc(), other.get_desc(), source.get_desc()}, attributes_of(fused),
        plan_.engine);
    finish(dnnl::binary(chosen), {{DNNL_ARG_SRC_0, source}, {DNNL_ARG_SRC_1, other}},
           chosen.dst_desc(), used, fused, chosen.scratchpad_desc());
  }

  void add_pooling(const OnnxNode& node) {
    const memory source = values_of(node.inputs[0]).memory;
    const Dims sides = source.get_desc().dims();
    const KernelWindow window = window_of(node);
    if (window.dilation != Sides{1, 1}) fail("MaxPool with dilations");
    const Sides size = window.output_size({sides[2], sides[3]});
    const dnnl::pooling_forward::primitive_desc chosen(
        {kInference, algorithm::pooling_max, source.get_desc(),
         any_layout({sides[0], sides[1], size.y, size.x}), dims(window.stride), dims(window.kernel),
         dims(window.before), dims(window.after)},
        plan_.engine);
    finish(dnnl::pooling_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(),
           {node.inputs[0]}, alone(node));
  }

  void add_concatenation(const OnnxNode& node) {
    if (integer(node, "axis").value_or(0) != 1) fail("Concat along other than channels");
    Dims dims = dims_of(node.inputs[0]);
    const auto size = [](const Dims& of) { return Dims(of.begin() + 2, of.end()); };
    dims[1] = 0;
    for (const std::string& input : node.inputs) {
      if (size(dims_of(input)) != size(dims)) fail("Concat of two sizes");
      dims[1] += dims_of(input)[1];
    }
    const memory::desc layout = channels_last(dims);
    const memory all = buffers_.take(layout);
    Dims offset(dims.size(), 0);
    for (const std::string& input : node.inputs) {
      const memory part = values_of(input).memory;
      const Dims sides = part.get_desc().dims();
      reorder(part, {layout.submemory_desc(sides, offset), plan_.engine, all.get_data_handle()});
      offset[1] += sides[1];
    }
    for (const std::string& input : node.inputs) release(input);
    values_[node.outputs[0]] = {.memory = all, .copies = {}};
  }

  // As OpenCV and torch enlarge images: centres of pixels at half integers.
  void add_resize(std::size_t i) {
    const OnnxNode& node = graph_.nodes[i];
    const std::string places = text(node, "coordinate_transformation_mode");
    const OnnxTensor* scales =
        node.inputs.size() == 3 && !node.inputs[2].empty() ? &constant(node.inputs[2]) : nullptr;
    if (text(node, "mode") != "linear" || scales == nullptr || scales->dims != Dims{4} ||
        !(places.empty() || places == "half_pixel" || places == "pytorch_half_pixel"))
      fail("Resize in another way than linear, by scales, between centres of pixels");
    const std::vector<float> factors = floats_of(*scales);
    const memory source = values_of(node.inputs[0]).memory;
    Dims target = source.get_desc().dims();
    if (factors[0] != 1 || factors[1] != 1 || factors[2] < 1 || factors[3] < 1 ||
        factors[2] != std::floor(factors[2]) || factors[3] != std::floor(factors[3]))
      fail("Resize by other than whole numbers");
    target[2] *= static_cast<memory::dim>(factors[2]);
    target[3] *= static_cast<memory::dim>(factors[3]);
    const Fused fused = fuse(i, target, Fusible::kFunctions);
    const dnnl::resampling_forward::primitive_desc chosen(
        {kInference, algorithm::resampling_linear, source.get_desc(), any_layout(target)},
        attributes_of(fused), plan_.engine);
    finish(dnnl::resampling_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(),
           {node.inputs[0]}, fused, chosen.scratchpad_desc());
  }

  // The operators that may be done with node i, whose output has these sides: those that alone use
  // what comes before them.
  Fused fuse(std::size_t i, const Dims& dims, Fusible fusible) {
    Fused fused = alone(graph_.nodes[i]);
    while (uses_.contains(fused.output) && uses_.at(fused.output) == 1) {
      const auto user = std::ranges::find_if(
          graph_.nodes.begin() + static_cast<std::ptrdiff_t>(i) + 1, graph_.nodes.end(),
          [&](const OnnxNode& node) {
            return is_used(node) && std::ranges::count(node.inputs, fused.output) > 0;
          });
      if (user == graph_.nodes.end() || user->outputs.size() != 1) break;
      if (fusible == Fusible::kRelu && user->type != "Relu") break;
      if (const auto function = function_of(*user)) {
        fused.functions.push_back(*function);
      } else {
        const std::string added = other_input(*user, fused.output);
        if (fusible != Fusible::kAll || user->type != "Add" || !fused.added.empty() ||
            !fused.functions.empty() || !values_.contains(added) || dims_of(added) != dims)
          break;
        fused.added = added;
      }
      fused.output = user->outputs[0];
      fused_.insert(static_cast<std::size_t>(user - graph_.nodes.begin()));
    }
    return fused;
  }

  static std::string other_input(const OnnxNode& node, const std::string& input) {
    return node.inputs.size() == 2 ? node.inputs[node.inputs[0] == input ? 1 : 0] : "";
  }

  // None where the node is no function of one number.
  [[nodiscard]] std::optional<Function> function_of(const OnnxNode& node) const {
    const std::string& type = node.type;
    if (type == "Relu") return Function{.kind = algorithm::eltwise_relu};
    if (type == "Sigmoid") return Function{.kind = algorithm::eltwise_logistic};
    if (node.inputs.size() != 2) return std::nullopt;
    const bool commutes = type == "Add" || type == "Mul";
    const auto number = the_number(node.inputs[commutes && !the_number(node.inputs[1]) ? 0 : 1]);
    if (!number) return std::nullopt;
    const auto linear = [](float alpha, float beta) {
      return Function{.kind = algorithm::eltwise_linear, .alpha = alpha, .beta = beta};
    };
    if (type == "Add") return linear(1, *number);
    if (type == "Sub") return linear(1, -*number);
    if (type == "Mul") return linear(*number, 0);
    if (type == "Div") return linear(1 / *number, 0);
    return std::nullopt;
  }

  // The constant of this name if it is one number.
  [[nodiscard]] std::optional<float> the_number(const std::string& name) const {
    const auto found = graph_.constants.find(name);
    if (found == graph_.constants.end() || found->second.data.size() != sizeof(float))
      return std::nullopt;
    return floats_of(found->second).front();
  }

  static dnnl::primitive_attr attributes_of(const Fused& fused) {
    dnnl::post_ops operators;
    if (!fused.added.empty()) operators.append_sum();
    for (const Function& function : fused.functions)
      operators.append_eltwise(1, function.kind, function.alpha, function.beta);
    dnnl::primitive_attr attributes;
    attributes.set_post_ops(operators);
    attributes.set_scratchpad_mode(dnnl::scratchpad_mode::user);  // finish() gives the memory
    return attributes;
  }

  void finish(const dnnl::primitive& primitive, Arguments arguments, const memory::desc& layout,
              const std::vector<std::string>& used, const Fused& fused,
              const memory::desc& scratchpad = {}) {
    const memory result = fused.added.empty() ? buffers_.take(layout) : taken(fused.added, layout);
    arguments.emplace(DNNL_ARG_DST, result);
    if (scratchpad.get_size() > 0) {
      const memory scratch = buffers_.take(scratchpad);
      arguments.emplace(DNNL_ARG_SCRATCHPAD, scratch);
      buffers_.give_back(scratch);
    }
    plan_.steps.push_back({primitive, std::move(arguments)});
    for (const std::string& name : used) release(name);
    values_[fused.output] = {.memory = result, .copies = {}};
  }

  // The value's memory, to be added to and written over; a copy where others will read it.
  memory taken(const std::string& name, const memory::desc& layout) {
    const memory own = values_of(name).memory;
    if (uses_[name] == 1 && own.get_desc() == layout) {
      for (const memory& copy : values_of(name).copies) buffers_.give_back(copy);
      values_.erase(name);
      return own;
    }
    const memory copy = buffers_.take(layout);
    reorder(own, copy);
    release(name);
    return copy;
  }

  const OnnxTensor& constant(const std::string& name) const {
    const auto found = graph_.constants.find(name);
    if (found == graph_.constants.end()) fail("weights that are no constants");
    return found->second;
  }

  std::vector<float> bias_of(const OnnxNode& node, memory::dim channels) const {
    if (node.inputs.size() < 3) return std::vector<float>(static_cast<std::size_t>(channels), 0.F);
    std::vector<float> bias = floats_of(constant(node.inputs[2]));
    if (static_cast<memory::dim>(bias.size()) != channels)
      fail(fmt::format("{} whose bias does not fit its weights", node.type));
    return bias;
  }

  // One number for all, or one for each channel.
  static Dims per_channel(const OnnxTensor& tensor, memory::dim channels) {
    Dims dims = tensor.dims;
    dims.insert(dims.begin(), dims.size() < 4 ? 4 - dims.size() : 0, 1);
    if (dims != Dims{1, 1, 1, 1} && dims != Dims{1, channels, 1, 1})
      fail("a constant that is neither one number nor one for each channel");
    return dims;
  }

  const Value& values_of(const std::string& name) const {
    const auto found = values_.find(name);
    if (found == values_.end()) fail(fmt::format("'{}', which nothing gives", name));
    return found->second;
  }

  [[nodiscard]] Dims dims_of(const std::string& name) const {
    return values_of(name).memory.get_desc().dims();
  }

  // The value as it is or, once for all who ask, as a copy.
  memory in_layout(const std::string& name, const memory::desc& layout) {
    (void)values_of(name);
    Value& value = values_.at(name);
    if (value.memory.get_desc() == layout) return value.memory;
    for (const memory& copy : value.copies)
      if (copy.get_desc() == layout) return copy;
    const memory copy = buffers_.take(layout);
    reorder(value.memory, copy);
    value.copies.push_back(copy);
    return copy;
  }

  // Constants are brought into their layout once.
  memory stored(const std::vector<float>& numbers, const Dims& dims, const memory::desc& layout) {
    std::vector<float> source = numbers;
    memory before(plain(dims), plan_.engine, source.data());
    memory after(layout, plan_.engine);
    dnnl::reorder(before, after).execute(plan_.stream, before, after);
    plan_.stream.wait();
    return after;
  }

  void release(const std::string& name) {
    if (--uses_[name] > 0) return;
    const Value& value = values_.at(name);
    buffers_.give_back(value.memory);
    std::ranges::for_each(value.copies, [this](const memory& copy) { buffers_.give_back(copy); });
    values_.erase(name);
  }

  void reorder(const memory& from, const memory& to) {
    plan_.steps.push_back({dnnl::reorder(from, to), {{DNNL_ARG_FROM, from}, {DNNL_ARG_TO, to}}});
  }

  const OnnxGraph& graph_;
  NetworkPlan plan_;
  Buffers buffers_{plan_.engine};
  std::map<std::string, int> uses_;  // by steps to come
  std::map<std::string, Value> values_;
  std::set<std::size_t> fused_;  // nodes that another does, too
};

}  // namespace

NetworkPlan plan_network(const OnnxGraph& graph, const std::string& output, const Dims& image) {
  return Planner(graph, output, image).take();
}

cv::Mat run(NetworkPlan& plan, const cv::Mat_<cv::Vec3f>& image) {
  CV_Assert(image.isContinuous());
  std::memcpy(plan.input.get_data_handle(), image.data, image.total() * image.elemSize());
  for (const auto& [primitive, arguments] : plan.steps) primitive.execute(plan.stream, arguments);
  plan.stream.wait();
  const Dims dims = plan.output.get_desc().dims();
  const std::vector<int> sizes(dims.begin(), dims.end());
  return cv::Mat(sizes, CV_32F, plan.output.get_data_handle()).clone();
}

}  // namespace edvo
