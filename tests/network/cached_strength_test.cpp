// SPDX-License-Identifier: MIT
#include "edvo/network/cached_strength.hpp"

#include "edvo/io/strength_file.hpp"
#include "edvo/network/edge_network.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"
#include "support/tiny_network.hpp"

#include <gmock/gmock.h>

namespace edvo {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Counts how often it was asked; its answer depends on the image.
class CountingStrength final : public EdgeStrength {
 public:
  explicit CountingStrength(int& count) : count_(count) {}
  [[nodiscard]] cv::Mat_<float> strength(const cv::Mat_<cv::Vec3b>& bgr) const override {
    ++count_;
    cv::Mat_<float> map(bgr.size());
    for (int y = 0; y < bgr.rows; ++y)
      for (int x = 0; x < bgr.cols; ++x) map(y, x) = static_cast<float>(bgr(y, x)[0] + x) / 1001.F;
    return map;
  }

 private:
  int& count_;
};

class CachedStrength : public testing::Test {
 protected:
  cv::Mat_<float> strength(const cv::Mat_<cv::Vec3b>& bgr, const std::string& fingerprint = "one") {
    const auto warn = [this](const std::string& warning) { warnings_.push_back(warning); };
    return make_cached_strength(std::make_unique<CountingStrength>(asked_), fingerprint,
                                {.folder = folder_, .warn = warn})
        ->strength(bgr);
  }
  [[nodiscard]] fs::path entry() const { return fs::directory_iterator(folder_)->path(); }
  [[nodiscard]] bool is_right(const cv::Mat_<float>& map) const {
    int ignored = 0;
    return cv::norm(map, CountingStrength(ignored).strength(image_), cv::NORM_INF) == 0;
  }

  test::TemporaryFolder temporary_;
  std::string folder_ = temporary_.path().string();
  cv::Mat_<cv::Vec3b> image_ = test::bright_square();
  std::vector<std::string> warnings_;
  int asked_ = 0;
};

TEST_F(CachedStrength, AsksOnceForEachImageAndNetwork) {
  EXPECT_TRUE(is_right(strength(image_)));
  EXPECT_TRUE(is_right(strength(image_)));
  EXPECT_EQ(asked_, 1);
  (void)strength(image_, "two");
  EXPECT_EQ(asked_, 2);
  image_(3, 5)[2] ^= 1;
  (void)strength(image_);
  EXPECT_EQ(asked_, 3);
  (void)strength(image_.reshape(3, image_.cols));
  EXPECT_EQ(asked_, 4);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(CachedStrength, KnowsAPartOfALargerImage) {
  const cv::Mat_<cv::Vec3b> part = image_(cv::Rect(10, 10, 30, 20));
  (void)strength(part);
  (void)strength(part.clone());
  EXPECT_EQ(asked_, 1);
}

TEST_F(CachedStrength, ComputesAgainWhatIsDamaged) {
  (void)strength(image_);
  const fs::path file = entry();
  const auto size = fs::file_size(file);
  for (const std::string& damage :
       {std::string("cut"), std::string("changed"), std::string("text")}) {
    if (damage == "cut") fs::resize_file(file, size / 2);
    if (damage == "changed") {
      std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
      stream.seekp(static_cast<std::streamoff>(size - 3)).put('\x7f');
    }
    if (damage == "text") std::ofstream(file, std::ios::trunc) << "no edge map";
    asked_ = 0;
    warnings_.clear();
    EXPECT_TRUE(is_right(strength(image_))) << damage;
    EXPECT_EQ(asked_, 1) << damage;
    EXPECT_THAT(warnings_,
                ElementsAre(HasSubstr(file.string() + ": a damaged edge map; computed again")));
    EXPECT_TRUE(is_right(strength(image_))) << damage;
    EXPECT_EQ(asked_, 1) << damage;
  }
}

TEST_F(CachedStrength, GoesOnWhereItCannotWrite) {
  folder_ = "/proc/nowhere";
  EXPECT_TRUE(is_right(strength(image_)));
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("/proc/nowhere")));
}

TEST(Fingerprint, ChangesWithWhateverChangesTheAnswer) {
  Model model = test::tiny_model();
  const std::string before = fingerprint(model);
  model.description.name = "another";
  model.description.licence = "another";
  EXPECT_EQ(fingerprint(model), before);
  const auto changes = [&](auto change) {
    Model other = model;
    change(other);
    return fingerprint(other) != before;
  };
  EXPECT_TRUE(changes([](Model& m) { m.description.input.mean[1] += 1e-3; }));
  EXPECT_TRUE(changes([](Model& m) { m.description.input.size = {64, 64}; }));
  EXPECT_TRUE(changes([](Model& m) { m.description.input.factor = 0.5; }));
  EXPECT_TRUE(changes([](Model& m) { m.description.output.index = 1; }));
  EXPECT_TRUE(changes([](Model& m) { m.description.output.activation = Activation::kNone; }));
  EXPECT_TRUE(changes([](Model& m) { m.description.sha256 = std::string(64, '0'); }));
  model.description.sha256.clear();
  EXPECT_EQ(fingerprint(model), before);
  model.weights += ' ';
  EXPECT_NE(fingerprint(model), before);
}

TEST(StrengthFile, KeepsEveryBit) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "map";
  EXPECT_EQ(find_strength(file), std::nullopt);
  cv::Mat_<float> strength(5, 7, 1.F / 3);
  strength(2, 3) = std::numeric_limits<float>::denorm_min();
  write_strength(file, strength(cv::Rect(1, 1, 4, 3)));
  const auto copy = find_strength(file);
  ASSERT_TRUE(copy);
  EXPECT_EQ(copy->size(), cv::Size(4, 3));
  EXPECT_EQ(cv::norm(*copy, strength(cv::Rect(1, 1, 4, 3)), cv::NORM_INF), 0);
  EXPECT_TRUE(test::fails_with(ErrorCode::kInput, {"not a regular file"},
                               [&] { (void)find_strength(folder.path()); }));
}

}  // namespace
}  // namespace edvo
