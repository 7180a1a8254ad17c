// SPDX-License-Identifier: MIT
#include "edvo/core/error.hpp"
#include "edvo/edge/inference.hpp"
#include "edvo/edge/onnx_graph.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <dnnl.hpp>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <ranges>
#include <set>
#include <unordered_map>

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

// oneDNN's threads are OpenMP's, whose number belongs to the thread that asks.
class ThreadCount {
 public:
  explicit ThreadCount(int count) { omp_set_num_threads(count); }
  ~ThreadCount() { omp_set_num_threads(before_); }
  ThreadCount(const ThreadCount&) = delete;
  ThreadCount& operator=(const ThreadCount&) = delete;

 private:
  int before_ = omp_get_max_threads();
};

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

// Along the two sides of an image: of a kernel, its steps, or what is added to an image's borders.
struct Pair {
  memory::dim y = 0, x = 0;
  [[nodiscard]] Dims dims() const { return {y, x}; }
  [[nodiscard]] bool operator==(const Pair&) const = default;
};

Pair pair_of(const OnnxNode& node, std::string_view name, Pair otherwise) {
  const std::vector<std::int64_t> values = integers(node, name);
  if (values.empty()) return otherwise;
  if (values.size() != 2) fail(fmt::format("{} of other than two dimensions", node.type));
  return {values[0], values[1]};
}

struct Window {
  Pair kernel, stride, dilation, before, after;

  [[nodiscard]] Pair output_size(Pair input) const {
    return {side(input.y, kernel.y, stride.y, dilation.y, before.y + after.y),
            side(input.x, kernel.x, stride.x, dilation.x, before.x + after.x)};
  }

 private:
  static memory::dim side(memory::dim input, memory::dim kernel, memory::dim stride,
                          memory::dim dilation, memory::dim added) {
    const memory::dim room = input + added - dilation * (kernel - 1) - 1;
    if (room < 0 || stride < 1) fail("an image smaller than a kernel");
    return room / stride + 1;
  }
};

Window window_of(const OnnxNode& node, Pair kernel) {
  const std::string automatic = text(node, "auto_pad");
  if (!automatic.empty() && automatic != "NOTSET")
    fail(fmt::format("{} with auto_pad {}", node.type, automatic));
  if (integer(node, "ceil_mode").value_or(0) != 0)
    fail(fmt::format("{} with ceil_mode", node.type));
  const std::vector<std::int64_t> pads = integers(node, "pads");
  Window window{.kernel = pair_of(node, "kernel_shape", kernel),
                .stride = pair_of(node, "strides", {1, 1}),
                .dilation = pair_of(node, "dilations", {1, 1}),
                .before = {},
                .after = {}};
  if (pads.size() == 4) {
    window.before = {pads[0], pads[1]};
    window.after = {pads[2], pads[3]};
  }
  return window;
}

// A transposed convolution that enlarges s times is a convolution with s * s times the channels,
// each for one place among s x s pixels, which are then spread: out[s q + r] takes the kernel at
// r + p - s d of in[q + d]. oneDNN's own is ten times slower where few channels come out.
struct Enlargement {
  memory::dim factor = 1;
  memory::dim first = 0, last = 0;  // d, of all r

  [[nodiscard]] memory::dim kernel() const { return last - first + 1; }
};

Enlargement enlargement_of(const OnnxNode& node, const Window& window) {
  const auto extra = integers(node, "output_padding");
  const memory::dim s = window.stride.y, k = window.kernel.y, p = window.before.y;
  if (window.stride.x != s || window.kernel.x != k || window.before.x != p ||
      window.after != Pair{p, p} || window.dilation != Pair{1, 1} ||
      std::ranges::any_of(extra, [](std::int64_t n) { return n != 0; }) ||
      integer(node, "group").value_or(1) != 1 || k - 2 * p != s || p < 0)
    fail("ConvTranspose that does not enlarge by its stride");
  Enlargement enlargement{.factor = s, .first = 0, .last = (s - 1 + p) / s};
  while (p - s * (enlargement.first - 1) <= k - 1) --enlargement.first;
  return enlargement;
}

// Input x output x k x k -> (s s output) x input x K x K.
std::vector<float> spread_weights(const std::vector<float>& weights, const Dims& dims,
                                  memory::dim before, const Enlargement& by) {
  const memory::dim inputs = dims[0], outputs = dims[1], k = dims[2], s = by.factor;
  const memory::dim K = by.kernel();
  std::vector<float> spread(static_cast<std::size_t>(s * s * outputs * inputs * K * K), 0.F);
  const auto tap = [&](memory::dim r, memory::dim d) { return r + before - s * d; };
  const auto inside = [k](memory::dim t) { return t >= 0 && t < k; };
  auto to = spread.begin();
  for (memory::dim ry = 0; ry < s; ++ry)
    for (memory::dim rx = 0; rx < s; ++rx)
      for (memory::dim output = 0; output < outputs; ++output)
        for (memory::dim input = 0; input < inputs; ++input)
          for (memory::dim dy = by.first; dy <= by.last; ++dy)
            for (memory::dim dx = by.first; dx <= by.last; ++dx, ++to)
              if (inside(tap(ry, dy)) && inside(tap(rx, dx)))
                *to = weights[static_cast<std::size_t>(
                    ((input * outputs + output) * k + tap(ry, dy)) * k + tap(rx, dx))];
  return spread;
}

// One image size's primitives, in their order, with all they need.
class Plan {
 public:
  Plan(const OnnxGraph& graph, const std::string& output, const Dims& image)
      : graph_(graph), image_(image) {
    ++uses_[output];
    ++uses_[graph.image];  // its memory takes the next image, too
    for (const OnnxNode& node : std::views::reverse(graph.nodes))
      if (is_used(node))
        for (const std::string& input : node.inputs) ++uses_[input];
    input_ = allocate(plain(image));
    values_[graph.image] = {.memory = input_, .copies = {}};
    for (std::size_t i = 0; i < graph.nodes.size(); ++i)
      if (is_used(graph.nodes[i]) && !fused_.contains(i)) add(i);
    output_ = in_layout(output, plain(dims_of(output)));
  }

  [[nodiscard]] const Dims& image() const { return image_; }

  [[nodiscard]] cv::Mat run(const cv::Mat& blob) {
    std::memcpy(input_.get_data_handle(), blob.data, blob.total() * sizeof(float));
    for (const Step& step : steps_) step.primitive.execute(stream_, step.arguments);
    stream_.wait();
    const Dims dims = output_.get_desc().dims();
    const std::vector<int> sizes(dims.begin(), dims.end());
    return cv::Mat(sizes, CV_32F, output_.get_data_handle()).clone();
  }

 private:
  using Arguments = std::unordered_map<int, memory>;

  struct Step {
    dnnl::primitive primitive;
    Arguments arguments;
  };

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
    if (kernel.dims.size() != 4 || groups < 1 || kernel.dims[0] % groups != 0 ||
        kernel.dims[1] * groups != source[1])
      fail("Conv whose weights do not fit its input");
    const Window window = window_of(node, {kernel.dims[2], kernel.dims[3]});
    if (window.kernel != Pair{kernel.dims[2], kernel.dims[3]})
      fail("Conv whose weights do not fit its kernel_shape");
    Dims weights = kernel.dims;
    if (groups > 1) {
      weights[0] /= groups;
      weights.insert(weights.begin(), groups);
    }
    const Pair size = window.output_size({source[2], source[3]});
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
    if (kernel.dims.size() != 4 || kernel.dims[0] != source[1] || kernel.dims[2] != kernel.dims[3])
      fail("ConvTranspose whose weights do not fit its input");
    const Window transposed = window_of(node, {kernel.dims[2], kernel.dims[3]});
    if (transposed.kernel != Pair{kernel.dims[2], kernel.dims[3]})
      fail("ConvTranspose whose weights do not fit its kernel_shape");
    const Enlargement by = enlargement_of(node, transposed);
    const memory::dim s = by.factor, K = by.kernel(), outputs = kernel.dims[1];
    const memory::dim height = source[2], width = source[3];
    std::vector<float> bias;
    for (memory::dim r = 0; r < s * s; ++r)
      std::ranges::copy(bias_of(node, outputs), std::back_inserter(bias));
    const Window window{.kernel = {K, K},
                        .stride = {1, 1},
                        .dilation = {1, 1},
                        .before = {-by.first, -by.first},
                        .after = {by.last, by.last}};
    Fused fused = fuse(i, {1, outputs, s * height, s * width}, Fusible::kFunctions);
    const std::string result = std::exchange(fused.output, fused.output + " before it is spread");
    uses_[fused.output] = 1;
    convolve(node.inputs[0], {s * s * outputs, source[1], K, K},
             spread_weights(floats_of(kernel), kernel.dims, transposed.before.y, by), bias, window,
             channels_last({1, s * s * outputs, height, width}), fused);
    // Both as height x s x width x s x channels.
    const Dims sides = {height, s, width, s, outputs};
    const memory::dim row = width * s * s * outputs;
    const memory::desc from(sides, kFloat, {row, s * outputs, s * s * outputs, outputs, 1});
    const memory::desc to(sides, kFloat, {row, width * s * outputs, s * outputs, outputs, 1});
    const memory spread = allocate(channels_last({1, outputs, s * height, s * width}));
    const memory packed = values_.at(fused.output).memory;
    const memory source_view(from, engine_, packed.get_data_handle());
    const memory target_view(to, engine_, spread.get_data_handle());
    steps_.push_back({dnnl::reorder(source_view, target_view),
                      {{DNNL_ARG_FROM, source_view}, {DNNL_ARG_TO, target_view}}});
    release(fused.output);
    values_[result] = {.memory = spread, .copies = {}};
  }

  void convolve(const std::string& input, const Dims& weights, const std::vector<float>& kernel,
                const std::vector<float>& bias, const Window& window, const memory::desc& target,
                const Fused& fused) {
    const Dims bias_dims = {static_cast<memory::dim>(bias.size())};
    const auto description = [&](algorithm way, const memory::desc& from, const memory::desc& to,
                                 Pair before, Pair after) {
      return dnnl::convolution_forward::desc(
          kInference, way, from, any_layout(weights), any_layout(bias_dims), to,
          window.stride.dims(), Pair{window.dilation.y - 1, window.dilation.x - 1}.dims(),
          before.dims(), after.dims());
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
      const Pair border = {window.before.y - ring, window.before.x - ring};
      Dims source = dims_of(input);
      for (const std::size_t side : {2, 3}) source[side] += 2 * ring;
      const dnnl::convolution_forward::primitive_desc chosen(
          description(algorithm::convolution_winograd, any_layout(source), target, border, border),
          attributes, engine_, true);
      if (chosen.get(true) != nullptr)
        return finish_with(chosen, ringed(input, ring, chosen.src_desc()));
    }
    // Layouts are those of the fastest implementation; operators fused to it may not change them.
    const dnnl::convolution_forward::primitive_desc fastest(
        description(algorithm::convolution_direct, any_layout(dims_of(input)), target,
                    window.before, window.after),
        engine_);
    const dnnl::convolution_forward::primitive_desc chosen(
        description(algorithm::convolution_direct, fastest.src_desc(), fastest.dst_desc(),
                    window.before, window.after),
        attributes, engine_);
    finish_with(chosen, in_layout(input, chosen.src_desc()));
  }

  // Winograd's way takes a quarter of the products, but more memory: from 64 channels on it is two
  // to three times as fast.
  static bool suits_winograd(const Dims& weights, const Window& window) {
    constexpr memory::dim kChannels = 64;
    return weights.size() == 4 && weights[0] >= kChannels && weights[1] >= kChannels &&
           window.kernel == Pair{3, 3} && window.stride == Pair{1, 1} &&
           window.dilation == Pair{1, 1} && window.before == window.after &&
           window.before.y == window.before.x;
  }

  // The value in a ring of zeros, so many pixels wide: oneDNN's Winograd knows one pixel of border.
  memory ringed(const std::string& name, memory::dim ring, const memory::desc& layout) {
    if (ring == 0) return in_layout(name, layout);
    const memory around(layout, engine_);  // not from what others write over
    std::memset(around.get_data_handle(), 0, layout.get_size());
    const memory::desc inner = layout.submemory_desc(dims_of(name), {0, 0, ring, ring});
    const memory inside(inner, engine_, around.get_data_handle());
    const memory source = values_of(name).memory;
    steps_.push_back(
        {dnnl::reorder(source, inside), {{DNNL_ARG_FROM, source}, {DNNL_ARG_TO, inside}}});
    return around;
  }

  void add_function(const OnnxNode& node, const Function& function) {
    const std::string& input = node.inputs[the_number(node.inputs[0]) ? 1 : 0];
    const memory source = values_of(input).memory;
    const dnnl::eltwise_forward::primitive_desc chosen(
        {kInference, function.kind, source.get_desc(), function.alpha, function.beta}, engine_);
    finish(dnnl::eltwise_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(), {input},
           {.output = node.outputs[0], .added = {}, .functions = {}});
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
        engine_);
    finish(dnnl::binary(chosen), {{DNNL_ARG_SRC_0, source}, {DNNL_ARG_SRC_1, other}},
           chosen.dst_desc(), used, fused, chosen.scratchpad_desc());
  }

  void add_pooling(const OnnxNode& node) {
    const memory source = values_of(node.inputs[0]).memory;
    const Dims dims = source.get_desc().dims();
    const Window window = window_of(node, {1, 1});
    if (window.dilation != Pair{1, 1}) fail("MaxPool with dilations");
    const Pair size = window.output_size({dims[2], dims[3]});
    const dnnl::pooling_forward::primitive_desc chosen(
        {kInference, algorithm::pooling_max, source.get_desc(),
         any_layout({dims[0], dims[1], size.y, size.x}), window.stride.dims(), window.kernel.dims(),
         window.before.dims(), window.after.dims()},
        engine_);
    finish(dnnl::pooling_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(),
           {node.inputs[0]}, {.output = node.outputs[0], .added = {}, .functions = {}});
  }

  void add_concatenation(const OnnxNode& node) {
    if (integer(node, "axis").value_or(0) != 1) fail("Concat along other than channels");
    std::vector<memory::desc> sources;
    Arguments arguments;
    for (const std::string& input : node.inputs) {
      const memory source = in_layout(input, channels_last(dims_of(input)));
      arguments.emplace(DNNL_ARG_MULTIPLE_SRC + static_cast<int>(sources.size()), source);
      sources.push_back(source.get_desc());
    }
    const dnnl::concat::primitive_desc chosen(1, sources, engine_);
    finish(dnnl::concat(chosen), std::move(arguments), chosen.dst_desc(), node.inputs,
           {.output = node.outputs[0], .added = {}, .functions = {}});
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
        attributes_of(fused), engine_);
    finish(dnnl::resampling_forward(chosen), {{DNNL_ARG_SRC, source}}, chosen.dst_desc(),
           {node.inputs[0]}, fused, chosen.scratchpad_desc());
  }

  // The operators that may be done with node i, whose output has these sides: those that alone use
  // what comes before them.
  Fused fuse(std::size_t i, const Dims& dims, Fusible fusible) {
    Fused fused{.output = graph_.nodes[i].outputs[0], .added = {}, .functions = {}};
    while (uses_.contains(fused.output) && uses_.at(fused.output) == 1) {
      const auto user = std::ranges::find_if(
          graph_.nodes.begin() + static_cast<std::ptrdiff_t>(i) + 1, graph_.nodes.end(),
          [&](const OnnxNode& node) { return std::ranges::count(node.inputs, fused.output) > 0; });
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
    const memory result = fused.added.empty() ? allocate(layout) : taken(fused.added, layout);
    arguments.emplace(DNNL_ARG_DST, result);
    if (scratchpad.get_size() > 0) {
      const memory scratch = allocate(scratchpad);
      arguments.emplace(DNNL_ARG_SCRATCHPAD, scratch);
      give_back(scratch);
    }
    steps_.push_back({primitive, std::move(arguments)});
    for (const std::string& name : used) release(name);
    values_[fused.output] = {.memory = result, .copies = {}};
  }

  // The value's memory, to be added to and written over; a copy where others will read it.
  memory taken(const std::string& name, const memory::desc& layout) {
    const memory own = values_of(name).memory;
    if (uses_[name] == 1 && own.get_desc() == layout) {
      for (const memory& copy : values_of(name).copies) give_back(copy);
      values_.erase(name);
      return own;
    }
    const memory copy = allocate(layout);
    steps_.push_back({dnnl::reorder(own, copy), {{DNNL_ARG_FROM, own}, {DNNL_ARG_TO, copy}}});
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
    const memory copy = allocate(layout);
    steps_.push_back(
        {dnnl::reorder(value.memory, copy), {{DNNL_ARG_FROM, value.memory}, {DNNL_ARG_TO, copy}}});
    value.copies.push_back(copy);
    return copy;
  }

  // Constants are brought into their layout once.
  memory stored(const std::vector<float>& numbers, const Dims& dims, const memory::desc& layout) {
    std::vector<float> source = numbers;
    memory before(plain(dims), engine_, source.data());
    memory after(layout, engine_);
    dnnl::reorder(before, after).execute(stream_, before, after);
    stream_.wait();
    return after;
  }

  // Steps run one after the other, so what no later step reads is written over.
  memory allocate(const memory::desc& layout) {
    const std::size_t bytes = layout.get_size();
    auto best = free_.end();
    for (auto it = free_.begin(); it != free_.end(); ++it)
      if (size_of(*it) >= bytes && (best == free_.end() || size_of(*it) < size_of(*best)))
        best = it;
    memory buffer;
    if (best != free_.end()) {
      buffer = *best;
      free_.erase(best);
    } else {
      buffer =
          memory({{static_cast<memory::dim>(bytes)}, memory::data_type::u8, Layout::a}, engine_);
      buffers_.push_back(buffer);
    }
    return {layout, engine_, buffer.get_data_handle()};
  }

  static std::size_t size_of(const memory& buffer) { return buffer.get_desc().get_size(); }

  void release(const std::string& name) {
    if (--uses_[name] > 0) return;
    const Value& value = values_.at(name);
    give_back(value.memory);
    std::ranges::for_each(value.copies, [this](const memory& copy) { give_back(copy); });
    values_.erase(name);
  }

  void give_back(const memory& used) {
    const auto buffer = std::ranges::find_if(buffers_, [&](const memory& candidate) {
      return candidate.get_data_handle() == used.get_data_handle();
    });
    free_.push_back(*buffer);
  }

  const OnnxGraph& graph_;
  Dims image_;
  dnnl::engine engine_{dnnl::engine::kind::cpu, 0};
  dnnl::stream stream_{engine_};
  std::map<std::string, int> uses_;  // by steps to come
  std::map<std::string, Value> values_;
  std::set<std::size_t> fused_;  // nodes that another does, too
  std::vector<memory> buffers_, free_;
  std::vector<Step> steps_;
  memory input_, output_;
};

// Threads meet after each layer, spinning, and wait for one that a busy core has put off. With
// fewer weights a layer takes less than that: such a network runs on one thread, beside others.
constexpr std::size_t kManyWeights = 1'000'000;

std::size_t weights_in(const OnnxGraph& graph) {
  std::size_t bytes = 0;
  for (const auto& [name, tensor] : graph.constants) bytes += tensor.data.size();
  return bytes / sizeof(float);
}

class OneDnnInference final : public Inference {
 public:
  OneDnnInference(OnnxGraph graph, std::string output, cv::Size size)
      : output_(std::move(output)), graph_(std::move(graph)) {
    (void)forward(cv::Mat(std::vector{1, 3, size.height, size.width}, CV_32F, cv::Scalar(0)));
  }

  [[nodiscard]] cv::Mat forward(const cv::Mat& blob) override {
    const ThreadCount threads(is_large_ ? std::max(1, cv::getNumThreads()) : 1);
    const Dims image(blob.size.p, blob.size.p + blob.dims);
    try {
      if (!plan_ || plan_->image() != image) plan_.emplace(graph_, output_, image);
      return plan_->run(blob);
    } catch (const dnnl::error& error) {
      fail(refusal(image, error.what()));
    } catch (const Error& error) {
      fail(refusal(image, error.what()));
    }
  }

 private:
  static std::string refusal(const Dims& image, const char* reason) {
    return fmt::format("oneDNN {} cannot run this network on an image of {} x {} px: {}",
                       onednn_version(), image[3], image[2], reason);
  }

  std::string output_;
  OnnxGraph graph_;
  bool is_large_ = weights_in(graph_) > kManyWeights;
  std::optional<Plan> plan_;
};

}  // namespace

std::string onednn_version() {
  const dnnl_version_t& version = *dnnl::version();
  return fmt::format("{}.{}.{}", version.major, version.minor, version.patch);
}

std::unique_ptr<Inference> make_onednn_inference(const OnnxGraph& graph, const std::string& output,
                                                 cv::Size size) {
  return std::make_unique<OneDnnInference>(graph, output, size);
}

}  // namespace edvo
