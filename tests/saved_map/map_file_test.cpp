// SPDX-License-Identifier: MIT
#include "edvo/saved_map/map_file.hpp"

#include "edvo/core/error.hpp"
#include "edvo/core/random.hpp"
#include "edvo/io/file.hpp"
#include "edvo/saved_map/map_lock.hpp"
#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace edvo {
namespace {

using ::testing::HasSubstr;

// Of odd size, so that every second pixel is one more than half; with noise, jumps and holes.
Place some_view(KeyframeId id, const Camera& camera, bool colour) {
  Random random{static_cast<std::uint64_t>(id)};
  Place view{.id = id};
  view.gray.create(camera.height, camera.width);
  for (auto& value : view.gray) value = static_cast<std::uint8_t>(random.below(256));
  view.half_depth.create((camera.height + 1) / 2, (camera.width + 1) / 2);
  for (auto& value : view.half_depth)
    value = static_cast<std::uint16_t>(random.below(3) * random.below(30'000));
  if (colour) {
    view.half_chroma.create(view.half_depth.size());
    for (auto& value : view.half_chroma)
      value = {static_cast<std::uint8_t>(random.below(256)),
               static_cast<std::uint8_t>(random.below(256))};
  }
  for (int i = 0; i < 5; ++i)
    view.points.push_back(back_project(camera, random.below(camera.width),
                                       random.below(camera.height), random.uniform(0.5, 4))
                              .cast<float>());
  return view;
}

SavedMap some_map() {
  SavedMap map{
      .origin = {.camera = {.fx = 8, .fy = -8.5, .cx = 4, .cy = 3, .width = 9, .height = 7},
                 .depth_scale = 5000,
                 .method = "canny+corner",
                 .config = "[window]\nkeyframes = 7\n",
                 .made_by = "edvo 0.1.0"},
      .keyframes = {},
      .views = {},
      .steps = {},
      .links = {}};
  for (int i = 0; i < 4; ++i)
    map.keyframes.push_back({.id = i,
                             .stamp = {.nanoseconds = 1305031102175304000 + i, .decimals = 6},
                             .segment = i / 3,
                             .world_from_camera = exp(Vector6d::Constant(0.1 * i))});
  for (const KeyframeId id : {0, 2}) map.views.push_back(some_view(id, map.origin.camera, id == 2));
  for (Place& view : map.views) view.stamp = map.keyframes[static_cast<std::size_t>(view.id)].stamp;
  map.steps = {{.from = 0, .to = 1, .information = Matrix6d::Identity() * 1e4}};
  map.links = {{.from = 0,
                .to = 2,
                .from_pose_to = exp(Vector6d::Constant(0.2)),
                .information = Matrix6d::Random()}};
  return map;
}

template <typename Image>
bool same_image(const Image& a, const Image& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin());
}

class MapFile : public testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path path() const { return folder_.path() / "room.map"; }
  test::TemporaryFolder folder_;
};

TEST_F(MapFile, LoadsWhatWasSaved) {
  const SavedMap saved = some_map();
  save_map(path(), saved);
  const SavedMap loaded = load_map(path());
  EXPECT_EQ(loaded.origin.camera.fy, -8.5);
  EXPECT_EQ(loaded.origin.camera.width, 9);
  EXPECT_EQ(loaded.origin.config, saved.origin.config);
  ASSERT_EQ(loaded.keyframes.size(), 4u);
  EXPECT_EQ(to_string(loaded.keyframes[3].stamp), to_string(saved.keyframes[3].stamp));
  EXPECT_EQ(loaded.keyframes[3].segment, 1);
  EXPECT_EQ(loaded.keyframes[3].world_from_camera.rotation.coeffs(),
            saved.keyframes[3].world_from_camera.rotation.coeffs());
  ASSERT_EQ(loaded.views.size(), 2u);
  for (const std::size_t i : {0, 1}) {
    EXPECT_EQ(loaded.views[i].id, saved.views[i].id);
    EXPECT_EQ(loaded.views[i].stamp, saved.views[i].stamp);
    EXPECT_TRUE(same_image(loaded.views[i].gray, saved.views[i].gray));
    EXPECT_TRUE(same_image(loaded.views[i].half_depth, saved.views[i].half_depth));
    EXPECT_TRUE(same_image(loaded.views[i].half_chroma, saved.views[i].half_chroma));
    EXPECT_EQ(loaded.views[i].points, saved.views[i].points);
  }
  EXPECT_EQ(loaded.steps.front().information, saved.steps.front().information);
  EXPECT_EQ(loaded.links.front().information, saved.links.front().information);
}

TEST_F(MapFile, SaveLoadSaveGivesTheSameBytes) {
  save_map(path(), some_map());
  const std::string first = read_file(path());
  save_map(path(), load_map(path()));
  EXPECT_EQ(read_file(path()), first);
}

TEST_F(MapFile, AnEmptyMapIsAMap) {
  SavedMap map = some_map();
  map.keyframes.clear(), map.views.clear(), map.steps.clear(), map.links.clear();
  save_map(path(), map);
  EXPECT_TRUE(load_map(path()).keyframes.empty());
}

TEST_F(MapFile, EveryFlippedByteIsFound) {
  save_map(path(), some_map());
  const std::string whole = read_file(path());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string flipped = whole;
    flipped[i] = static_cast<char>(flipped[i] ^ (1 << i % 8));
    folder_.write("room.map", flipped);
    EXPECT_TRUE(test::fails_with(ErrorCode::kMap, {"room.map"}, [&] { (void)load_map(path()); }))
        << "byte " << i;
  }
}

TEST_F(MapFile, EveryMissingOrAddedByteIsFound) {
  save_map(path(), some_map());
  const std::string whole = read_file(path());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    folder_.write("room.map", std::string_view(whole).substr(0, size));
    EXPECT_TRUE(test::fails_with(ErrorCode::kMap, {"room.map"}, [&] { (void)load_map(path()); }))
        << size << " bytes";
  }
  folder_.write("room.map", whole + '\0');
  EXPECT_TRUE(test::fails_with(ErrorCode::kMap, {"END"}, [&] { (void)load_map(path()); }));
}

TEST_F(MapFile, NamesTheDamagedSection) {
  save_map(path(), some_map());
  std::string bytes = read_file(path());
  bytes[bytes.find("POSE") + 30] ^= 1;
  folder_.write("room.map", bytes);
  EXPECT_TRUE(test::fails_with(ErrorCode::kMap, {"section 2 (POSE) of this map is damaged"},
                               [&] { (void)load_map(path()); }));
}

TEST_F(MapFile, RefusesASegmentOrAPointThatNoMapHas) {
  const auto refuses = [&](const SavedMap& map, const std::string& section) {
    save_map(path(), map);
    EXPECT_TRUE(test::fails_with(ErrorCode::kMap, {section}, [&] { (void)load_map(path()); }));
  };
  SavedMap map = some_map();
  map.keyframes[1].segment = 4;
  refuses(map, "POSE");
  map = some_map();
  map.keyframes[1].world_from_camera.translation.x() = std::nan("");
  refuses(map, "POSE");
  map = some_map();
  map.views[0].points[0] = {100, 0, 1};
  refuses(map, "VIEW");
  map = some_map();
  map.links[0].to = 4;
  refuses(map, "LINK");
  map = some_map();
  map.origin.camera.fx = 0;
  refuses(map, "HEAD");
}

TEST_F(MapFile, AFileThatCannotBeWrittenLeavesTheOldOne) {
  save_map(path(), some_map());
  const std::string old = read_file(path());
  std::filesystem::create_directory(path().string() + ".part");
  EXPECT_TRUE(
      test::fails_with(ErrorCode::kOutput, {"room.map"}, [&] { save_map(path(), some_map()); }));
  EXPECT_EQ(read_file(path()), old);
}

TEST_F(MapFile, TheSecondToLockItIsRefused) {
  {
    const MapLock lock(path());
    EXPECT_TRUE(test::fails_with(ErrorCode::kMap, {"another program"},
                                 [&] { const MapLock second(path()); }));
  }
  EXPECT_NO_THROW(const MapLock again(path()));
  EXPECT_FALSE(std::filesystem::exists(path().string() + ".lock"));
}

}  // namespace
}  // namespace edvo
