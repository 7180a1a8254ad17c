// SPDX-License-Identifier: MIT
#include "edvo/network/onednn_plan.hpp"

#include "edvo/core/error.hpp"
#include "edvo/network/convolution_window.hpp"
#include "edvo/network/onednn_functions.hpp"
#include "edvo/network/onednn_values.hpp"
#include "edvo/network/onednn_version.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ranges>
#include <set>

namespace edvo {
namespace {

using dnnl::algorithm;
using dnnl::memory;
using Dims = memory::dims;

constexpr auto kFloat = memory::data_type::f32;
constexpr auto kInference = dnnl::prop_kind::forward_inference;

[[noreturn]] void fail(const std::string& reason) {
  throw Error(ErrorCode::kModel, reason);
}

Dims dims(Sides sides) {
  return {sides.y, sides.x};
}

// Turns a graph's nodes into steps, in their order.
class Planner {
 public:
  Planner(const OnnxGraph& graph, const std::string& output, const Dims& image) : graph_(graph) {
    plan_.image = image;
    values_.expect_reading(output);
    values_.expect_reading(graph.image);  // its memory takes the next image, too
    for (auto node = graph.nodes.rbegin(); node != graph.nodes.rend(); ++node)
      if (is_used(*node))
        for (const std::string& input : node->inputs) values_.expect_reading(input);
    plan_.input = buffers().take(channels_last(image));
    values_.put(graph.image, plan_.input);
    for (std::size_t i = 0; i < graph.nodes.size(); ++i)
      if (is_used(graph.nodes[i]) && !fused_.contains(i)) add(i);
    plan_.output = values_.in_layout(output, plain_layout(values_.dims_of(output)));
  }

  [[nodiscard]] NetworkPlan take() {
    plan_.buffers = buffers().release();
    return std::move(plan_);
  }

 private:
  using Arguments = std::unordered_map<int, memory>;

  // oneDNN's Winograd knows nothing but Relu.
  enum class Fusible { kRelu, kFunctions, kAll };

  static FusedOperators alone(const OnnxNode& node) {
    return {.output = node.outputs[0], .added = {}, .functions = {}};
  }

  [[nodiscard]] bool is_used(const OnnxNode& node) const {
    return std::ranges::any_of(node.outputs,
                               [this](const std::string& name) { return values_.is_read(name); });
  }

  void add(std::size_t i) {
    const OnnxNode& node = graph_.nodes[i];
    if (node.outputs.size() != 1 || node.inputs.empty())
      fail(fmt::format("{} with {} outputs", node.type, node.outputs.size()));
    if (const auto function = function_of(graph_, node))
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
    const Dims source = values_.dims_of(node.inputs[0]);
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
    const FusedOperators fused =
        fuse(i, target, suits_winograd(weights, window) ? Fusible::kRelu : Fusible::kAll);
    convolve(node.inputs[0], weights, floats_of(kernel), bias_of(node, target[1]), window,
             any_layout(target), fused);
  }

  void add_enlargement(std::size_t i) {
    const OnnxNode& node = graph_.nodes[i];
    const Dims source = values_.dims_of(node.inputs[0]);
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
    FusedOperators fused = fuse(i, {1, outputs, height, width}, Fusible::kFunctions);
    const std::string result = std::exchange(fused.output, fused.output + " before it is spread");
    values_.expect_reading(fused.output);
    convolve(node.inputs[0], {s * s * outputs, source[1], K, K}, spread_weights(kernel, by), bias,
             by.window, channels_last({1, s * s * outputs, places.y, places.x}), fused);
    // Both as height x s x width x s x channels.
    const Dims sides = {places.y, s, places.x, s, outputs};
    const memory::dim row = places.x * s * s * outputs;
    const memory::desc from(sides, kFloat, {row, s * outputs, s * s * outputs, outputs, 1});
    const memory::desc to(sides, kFloat, {row, places.x * s * outputs, s * outputs, outputs, 1});
    const memory::desc spread = channels_last({1, outputs, s * places.y, s * places.x});
    memory all = buffers().take(spread);
    const memory packed = values_.at(fused.output);
    values_.reorder({from, plan_.engine, packed.get_data_handle()},
                    {to, plan_.engine, all.get_data_handle()});
    values_.release(fused.output);
    if (by.margin > 0) {
      const Dims inner = {1, outputs, height, width};
      const memory cut = buffers().take(channels_last(inner));
      values_.reorder({spread.submemory_desc(inner, {0, 0, by.margin, by.margin}), plan_.engine,
                       all.get_data_handle()},
                      cut);
      buffers().give_back(std::exchange(all, cut));
    }
    values_.put(result, all);
  }

  void convolve(const std::string& input, const Dims& weights, const std::vector<float>& kernel,
                const std::vector<float>& bias, const KernelWindow& window,
                const memory::desc& target, const FusedOperators& fused) {
    const Dims bias_dims = {static_cast<memory::dim>(bias.size())};
    const auto description = [&](const dnnl::primitive_attr& attributes, IfUnknown if_unknown,
                                 algorithm way, const memory::desc& from, const memory::desc& to,
                                 Sides before, Sides after) {
      return described<dnnl::convolution_forward>(
          plan_.engine, attributes, if_unknown, kInference, way, from, any_layout(weights),
          any_layout(bias_dims), to, dims(window.stride),
          Dims{window.dilation.y - 1, window.dilation.x - 1}, dims(before), dims(after));
    };
    const auto finish_with = [&](const dnnl::convolution_forward::primitive_desc& chosen,
                                 const memory& source) {
      finish(dnnl::convolution_forward(chosen),
             {{DNNL_ARG_SRC, source},
              {DNNL_ARG_WEIGHTS, values_.stored(kernel, weights, chosen.weights_desc())},
              {DNNL_ARG_BIAS, values_.stored(bias, bias_dims, chosen.bias_desc())}},
             chosen.dst_desc(), {input}, fused, chosen.scratchpad_desc());
    };
    const dnnl::primitive_attr attributes = attributes_of(fused);
    if (suits_winograd(weights, window)) {
      const memory::dim ring = std::max<memory::dim>(0, window.before.y - 1);
      const Sides border = {window.before.y - ring, window.before.x - ring};
      Dims source = values_.dims_of(input);
      for (const std::size_t side : {2, 3}) source[side] += 2 * ring;
      const auto chosen =
          description(attributes, IfUnknown::kLeaveEmpty, algorithm::convolution_winograd,
                      any_layout(source), target, border, border);
      if (chosen.get(true) != nullptr)
        return finish_with(chosen, values_.in_ring(input, ring, chosen.src_desc()));
    }
    // Layouts are those of the fastest implementation; operators fused to it may not change them.
    const auto fastest =
        description({}, IfUnknown::kThrow, algorithm::convolution_direct,
                    any_layout(values_.dims_of(input)), target, window.before, window.after);
    const auto chosen =
        description(attributes, IfUnknown::kThrow, algorithm::convolution_direct,
                    fastest.src_desc(), fastest.dst_desc(), window.before, window.after);
    finish_with(chosen, values_.in_layout(input, chosen.src_desc()));
  }

  void add_function(const OnnxNode& node, const ElementFunction& function) {
    const std::string& input = node.inputs[single_number(graph_, node.inputs[0]) ? 1 : 0];
    const memory source = values_.at(input);
    const auto chosen = described_function(plan_.engine, function.kind, source.get_desc(),
                                           function.alpha, function.beta);
    finish(dnnl::eltwise_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(), {input},
           alone(node));
  }

  void add_binary(std::size_t i, algorithm kind) {
    const OnnxNode& node = graph_.nodes[i];
    std::string first = node.inputs[0], second = node.inputs.at(1);
    const bool commutes = kind == algorithm::binary_add || kind == algorithm::binary_mul;
    if (commutes && graph_.constants.contains(first)) std::swap(first, second);
    const memory source = values_.at(first);
    std::vector<std::string> used = {first};
    memory other;
    if (const auto found = graph_.constants.find(second); found != graph_.constants.end()) {
      const Dims dims = per_channel(found->second, values_.dims_of(first)[1]);
      other = values_.stored(floats_of(found->second), dims, plain_layout(dims));
    } else {
      if (values_.dims_of(second) != values_.dims_of(first))
        fail(fmt::format("{} of two sizes", node.type));
      other = values_.in_layout(second, source.get_desc());
      used.push_back(second);
    }
    const FusedOperators fused = fuse(i, values_.dims_of(first), Fusible::kFunctions);
    const auto chosen =
        described<dnnl::binary>(plan_.engine, attributes_of(fused), IfUnknown::kThrow, kind,
                                source.get_desc(), other.get_desc(), source.get_desc());
    finish(dnnl::binary(chosen), {{DNNL_ARG_SRC_0, source}, {DNNL_ARG_SRC_1, other}},
           chosen.dst_desc(), used, fused, chosen.scratchpad_desc());
  }

  void add_pooling(const OnnxNode& node) {
    const memory source = values_.at(node.inputs[0]);
    const Dims sides = dims_of(source.get_desc());
    const KernelWindow window = window_of(node);
    if (window.dilation != Sides{1, 1}) fail("MaxPool with dilations");
    const Sides size = window.output_size({sides[2], sides[3]});
    const auto chosen = described_maximum(
        plan_.engine, source.get_desc(), any_layout({sides[0], sides[1], size.y, size.x}),
        dims(window.stride), dims(window.kernel), dims(window.before), dims(window.after));
    finish(dnnl::pooling_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(),
           {node.inputs[0]}, alone(node));
  }

  void add_concatenation(const OnnxNode& node) {
    if (integer(node, "axis").value_or(0) != 1) fail("Concat along other than channels");
    Dims dims = values_.dims_of(node.inputs[0]);
    const auto size = [](const Dims& of) { return Dims(of.begin() + 2, of.end()); };
    dims[1] = 0;
    for (const std::string& input : node.inputs) {
      if (size(values_.dims_of(input)) != size(dims)) fail("Concat of two sizes");
      dims[1] += values_.dims_of(input)[1];
    }
    const memory::desc layout = channels_last(dims);
    const memory all = buffers().take(layout);
    Dims offset(dims.size(), 0);
    for (const std::string& input : node.inputs) {
      const memory part = values_.at(input);
      const Dims sides = dims_of(part.get_desc());
      values_.reorder(part,
                      {layout.submemory_desc(sides, offset), plan_.engine, all.get_data_handle()});
      offset[1] += sides[1];
    }
    for (const std::string& input : node.inputs) values_.release(input);
    values_.put(node.outputs[0], all);
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
    const memory source = values_.at(node.inputs[0]);
    Dims target = dims_of(source.get_desc());
    if (factors[0] != 1 || factors[1] != 1 || factors[2] < 1 || factors[3] < 1 ||
        factors[2] != std::floor(factors[2]) || factors[3] != std::floor(factors[3]))
      fail("Resize by other than whole numbers");
    target[2] *= static_cast<memory::dim>(factors[2]);
    target[3] *= static_cast<memory::dim>(factors[3]);
    const FusedOperators fused = fuse(i, target, Fusible::kFunctions);
    const auto chosen = described<dnnl::resampling_forward>(
        plan_.engine, attributes_of(fused), IfUnknown::kThrow, kInference,
        algorithm::resampling_linear, source.get_desc(), any_layout(target));
    finish(dnnl::resampling_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(),
           {node.inputs[0]}, fused, chosen.scratchpad_desc());
  }

  // The operators that may be done with node i, whose output has these sides: those that alone use
  // what comes before them.
  FusedOperators fuse(std::size_t i, const Dims& dims, Fusible fusible) {
    FusedOperators fused = alone(graph_.nodes[i]);
    while (values_.is_read_once(fused.output)) {
      const auto user = std::ranges::find_if(
          graph_.nodes.begin() + static_cast<std::ptrdiff_t>(i) + 1, graph_.nodes.end(),
          [&](const OnnxNode& node) {
            return is_used(node) && std::ranges::count(node.inputs, fused.output) > 0;
          });
      if (user == graph_.nodes.end() || user->outputs.size() != 1) break;
      if (fusible == Fusible::kRelu && user->type != "Relu") break;
      if (const auto function = function_of(graph_, *user)) {
        fused.functions.push_back(*function);
      } else {
        const std::string added = other_input(*user, fused.output);
        if (fusible != Fusible::kAll || user->type != "Add" || !fused.added.empty() ||
            !fused.functions.empty() || !values_.contains(added) || values_.dims_of(added) != dims)
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

  void finish(const dnnl::primitive& primitive, Arguments arguments, const memory::desc& layout,
              const std::vector<std::string>& used, const FusedOperators& fused,
              const memory::desc& scratchpad = {}) {
    const memory result =
        fused.added.empty() ? buffers().take(layout) : values_.to_add_to(fused.added, layout);
    arguments.emplace(DNNL_ARG_DST, result);
    if (scratchpad.get_size() > 0) {
      const memory scratch = buffers().take(scratchpad);
      arguments.emplace(DNNL_ARG_SCRATCHPAD, scratch);
      buffers().give_back(scratch);
    }
    plan_.steps.push_back({primitive, std::move(arguments)});
    for (const std::string& name : used) values_.release(name);
    values_.put(fused.output, result);
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

  [[nodiscard]] PlanBuffers& buffers() { return values_.buffers(); }

  const OnnxGraph& graph_;
  NetworkPlan plan_;
  PlanValues values_{plan_};
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
  const Dims dims = dims_of(plan.output.get_desc());
  const std::vector<int> sizes(dims.begin(), dims.end());
  return cv::Mat(sizes, CV_32F, plan.output.get_data_handle()).clone();
}

}  // namespace edvo
