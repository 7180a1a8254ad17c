// SPDX-License-Identifier: MIT
#include "edvo/io/model_description.hpp"

#include "edvo/core/did_you_mean.hpp"
#include "edvo/core/parse_toml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <vector>

namespace edvo {
namespace {

constexpr double kLargestSide = 16384;   // [px]
constexpr double kLargestStride = 1024;  // [px]
constexpr double kLargestFactor = 8;
constexpr std::size_t kHashDigits = 64;

[[noreturn]] void refuse(const std::string& source, const toml::node& node,
                         const std::string& reason) {
  throw Error(ErrorCode::kModel,
              fmt::format("{}:{}: {}", source, node.source().begin.line, reason));
}

// One table of the file. It notes which keys were asked for, so that others can be refused.
class Reader {
 public:
  Reader(const toml::table& table, std::string prefix, const std::string& source)
      : table_(table), prefix_(std::move(prefix)), source_(source) {}

  [[nodiscard]] bool has(std::string_view key) const { return table_.contains(key); }

  [[noreturn]] void refuse_key(std::string_view key, const std::string& reason) const {
    refuse(source_, *table_.get(key), fmt::format("{}{}: {}", prefix_, key, reason));
  }

  void read(std::string_view key, std::string& value) {
    const toml::node* const node = find(key);
    if (node == nullptr) return;
    if (!node->is_string()) refuse_key(key, "expected text in quotes");
    value = *node->value<std::string>();
  }

  void read(std::string_view key, double& value, const Range& range) {
    if (const toml::node* const node = find(key)) value = number(key, *node, range);
  }

  void read(std::string_view key, int& value, const Range& range) {
    if (const toml::node* const node = find(key)) value = whole_number(key, *node, range);
  }

  template <std::size_t N>
  void read(std::string_view key, std::array<double, N>& values, const Range& range) {
    if (const toml::array* const array = find_array(key, N))
      for (std::size_t i = 0; i < N; ++i) values[i] = number(key, (*array)[i], range);
  }

  void read(std::string_view key, cv::Size& size, const Range& range) {
    if (const toml::array* const array = find_array(key, 2))
      size = {whole_number(key, (*array)[0], range), whole_number(key, (*array)[1], range)};
  }

  template <typename Enum>
  requires std::is_enum_v<Enum>
  void read(std::string_view key, Enum& value) {
    std::string word;
    read(key, word);
    if (!has(key)) return;
    std::vector<std::string> names;
    for (const auto& [candidate, name] : EnumNames<Enum>::names) {
      if (name == word) value = candidate;
      names.emplace_back(name);
    }
    if (std::ranges::find(names, word) == names.end())
      refuse_key(key, fmt::format("unknown value '{}'{}; allowed: {}", word,
                                  did_you_mean(word, names), fmt::join(names, ", ")));
  }

  [[nodiscard]] Reader group(std::string_view key) {
    static const toml::table kEmpty;
    const toml::node* const node = find(key);
    if (node == nullptr) return {kEmpty, fmt::format("{}.", key), source_};
    if (!node->is_table()) refuse_key(key, fmt::format("expected a table [{}]", key));
    return {*node->as_table(), fmt::format("{}.", key), source_};
  }

  void refuse_others() const {
    for (const auto& [key, node] : table_)
      if (std::ranges::find(known_, key.str()) == known_.end())
        refuse(source_, node,
               fmt::format("unknown key '{}{}'{}; known are {}", prefix_, key.str(),
                           did_you_mean(key.str(), known_), fmt::join(known_, ", ")));
  }

 private:
  const toml::node* find(std::string_view key) {
    known_.emplace_back(key);
    return table_.get(key);
  }

  const toml::array* find_array(std::string_view key, std::size_t count) {
    const toml::node* const node = find(key);
    if (node == nullptr) return nullptr;
    if (!node->is_array() || node->as_array()->size() != count)
      refuse_key(key, fmt::format("expected {} numbers in brackets", count));
    return node->as_array();
  }

  double number(std::string_view key, const toml::node& node, const Range& range) const {
    if (!node.is_number()) refuse_key(key, "expected a number");
    const double value = *node.value<double>();
    if (!(value >= range.lowest && value <= range.highest))
      refuse_key(key, fmt::format("{} is out of range, allowed: {} to {}", value, range.lowest,
                                  range.highest));
    return value;
  }

  int whole_number(std::string_view key, const toml::node& node, const Range& range) const {
    if (!node.is_integer()) refuse_key(key, "expected a whole number");
    return static_cast<int>(number(key, node, range));
  }

  const toml::table& table_;
  std::string prefix_;  // "input."
  const std::string& source_;
  std::vector<std::string> known_;
};

NetworkInput read_input(Reader reader) {
  NetworkInput input;
  reader.read("channels", input.channels);
  reader.read("mean", input.mean, Range{-1e4, 1e4});
  reader.read("scale", input.scale, Range{1e-6, 1e6});
  reader.read("multiple_of", input.multiple_of, Range{1, kLargestStride});
  reader.read("padding", input.padding);
  reader.read("size", input.size, Range{1, kLargestSide});
  reader.read("factor", input.factor, Range{1 / kLargestFactor, kLargestFactor});
  reader.refuse_others();
  for (const char* key : {"multiple_of", "factor"})
    if (reader.has("size") && reader.has(key))
      reader.refuse_key(key, "input.size has fixed the size; leave one of them out");
  return input;
}

NetworkOutput read_output(Reader reader) {
  NetworkOutput output;
  reader.read("name", output.name);
  reader.read("index", output.index, Range{-1, 1000});
  reader.read("activation", output.activation);
  reader.refuse_others();
  if (reader.has("name") && reader.has("index"))
    reader.refuse_key("index", "output.name has chosen the output; leave one of them out");
  return output;
}

// With the escapes that TOML needs.
std::string quoted(const std::string& text) {
  std::ostringstream stream;
  stream << toml::value<std::string>(text);
  return stream.str();
}

template <typename Enum>
std::string quoted(Enum value) {
  return fmt::format("\"{}\"", name_of(value));
}

bool is_hash(std::string_view text) {
  return text.size() == kHashDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

ModelDescription model_description_from_toml(std::string_view text, const std::string& source) {
  const toml::table table = parse_toml(text, source, ErrorCode::kModel);
  ModelDescription model;
  Reader reader(table, "", source);
  reader.read("name", model.name);
  reader.read("file", model.file);
  reader.read("sha256", model.sha256);
  reader.read("licence", model.licence);
  reader.read("source", model.source);
  model.input = read_input(reader.group("input"));
  model.output = read_output(reader.group("output"));
  reader.refuse_others();
  if (model.file.empty())
    throw Error(ErrorCode::kModel,
                fmt::format("{}: file is missing: the name of the ONNX file beside it", source));
  std::ranges::transform(model.sha256, model.sha256.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c);
  });
  if (reader.has("sha256") && !is_hash(model.sha256))
    reader.refuse_key("sha256", fmt::format("expected {} hexadecimal digits", kHashDigits));
  return model;
}

std::string to_toml(const ModelDescription& model) {
  const NetworkInput& input = model.input;
  const NetworkOutput& output = model.output;
  // A checksum that is not known is left out: an empty one would be refused.
  const std::string checksum =
      model.sha256.empty() ? "" : fmt::format("sha256 = {}\n", quoted(model.sha256));
  std::string text = fmt::format(
      "name = {}\nfile = {}\n{}licence = {}\nsource = {}\n\n[input]\nchannels = {}\n"
      "mean = [{}, {}, {}]\nscale = {}\npadding = {}\n",
      quoted(model.name), quoted(model.file), checksum, quoted(model.licence), quoted(model.source),
      quoted(input.channels), input.mean[0], input.mean[1], input.mean[2], input.scale,
      quoted(input.padding));
  text += input.size.empty()
              ? fmt::format("multiple_of = {}\nfactor = {}\n", input.multiple_of, input.factor)
              : fmt::format("size = [{}, {}]\n", input.size.width, input.size.height);
  text += output.name.empty() ? fmt::format("\n[output]\nindex = {}\n", output.index)
                              : fmt::format("\n[output]\nname = {}\n", quoted(output.name));
  return text + fmt::format("activation = {}\n", quoted(output.activation));
}

}  // namespace edvo
