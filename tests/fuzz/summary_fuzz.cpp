// SPDX-License-Identifier: MIT
// What edvo bench reads of an earlier run: its summary, if it does not nest too deeply.
#include "edvo/core/nesting.hpp"
#include "fuzz/memory_file.hpp"

#include <nlohmann/json.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using Json = nlohmann::ordered_json;
  const std::string_view text = edvo::fuzz::text_of(data, size);
  if (edvo::line_nested_too_deeply_in_json(text)) return 0;
  const Json summary = Json::parse(text, nullptr, false);
  if (summary.is_discarded()) return 0;
  const std::string again = summary.dump(2, ' ', false, Json::error_handler_t::replace);
  edvo::fuzz::require(!edvo::line_nested_too_deeply_in_json(again));
  edvo::fuzz::require(Json::accept(again));
  return 0;
}
