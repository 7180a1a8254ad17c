# edvo_embed(FILE SYMBOL OUT): a C++ source with the bytes of FILE as
# `extern const std::string_view edvo::SYMBOL`.
function(edvo_embed file symbol out)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  file(CONFIGURE OUTPUT ${out} @ONLY CONTENT [[
#include <string_view>
namespace edvo {
namespace {
constexpr unsigned char kBytes[] = {@bytes@};
}
extern const std::string_view @symbol@;
const std::string_view @symbol@(reinterpret_cast<const char*>(kBytes), sizeof kBytes);
}  // namespace edvo
]])
endfunction()
