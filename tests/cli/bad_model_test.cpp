// SPDX-License-Identifier: MIT
// A model that does not fit ends a run before it begins: status 6, one line, no folder.
#include "edvo/core/error.hpp"
#include "edvo/core/sha256.hpp"
#include "edvo/io/file.hpp"
#include "support/program.hpp"
#include "support/sliding_sequence.hpp"
#include "support/temporary_folder.hpp"
#include "support/tiny_network.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const std::string kLumaOfGreen("\xa2\x45\x16\x3f", 4);  // 0.587F, a weight of the tiny network
const std::string kNan("\x00\x00\xc0\x7f", 4);

class BadModel : public testing::Test {
 protected:
  void SetUp() override { test::write_sliding_sequence(sequence_, {.frames = 2}); }

  void expect_refused(const std::string& onnx, const std::string& toml,
                      const std::string& part) const {
    folder_.write("bad.onnx", onnx);
    const fs::path description = folder_.write("bad.toml", "file = 'bad.onnx'\n" + toml);
    const fs::path out = folder_.path() / "out";
    const auto result = test::run_edvo("run " + sequence_.string() + " --model " +
                                       description.string() + " -o " + out.string() + " 2>&1");
    EXPECT_EQ(result.status, static_cast<int>(ErrorCode::kModel)) << result.output;
    EXPECT_THAT(result.output, HasSubstr(part));
    EXPECT_THAT(result.output, HasSubstr("edvo: "));
    EXPECT_FALSE(fs::exists(out));
  }

  test::TemporaryFolder folder_;
  fs::path sequence_ = folder_.path() / "sliding";
  std::string good_ = test::tiny_model().weights;
  std::string rest_ = "[input]\nscale = 0.004\n[output]\nindex = 0\nactivation = 'sigmoid'\n";
};

TEST_F(BadModel, EndsTheRunBeforeItBegins) {
  expect_refused("no network", rest_, "bad.onnx: not an ONNX file");
  expect_refused(good_.substr(0, good_.size() / 2), rest_, "bad.onnx: not an ONNX file");
  expect_refused(good_, "sha256 = '" + sha256("x") + "'\n" + rest_, "bad.onnx: its SHA-256 is");
  expect_refused(good_, "hash = ''\n" + rest_, "bad.toml:2: unknown key 'hash'");
  expect_refused(test::patched(good_, "Sqrt", "Sqrr"), rest_, "Sqrr");
  expect_refused(test::patched(good_, kLumaOfGreen, kNan), rest_, "are not all finite");
  expect_refused(good_, "[output]\nindex = 7\n", "output.index 7 is out of range");
  expect_refused(good_, "[output]\nindex = 1\n", "output 'coarse' has the shape");
  expect_refused(good_, "[output]\nindex = 0\n", "lack activation = \"sigmoid\"");
  expect_refused(good_, "[input]\nmultiple_of = 128\n[output]\nindex = 0\n",
                 "an image of 160 x 120 px is too small");
}

}  // namespace
}  // namespace edvo
