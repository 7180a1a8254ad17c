// SPDX-License-Identifier: MIT
#include "edvo/io/ply_file.hpp"

#include "support/error_matcher.hpp"
#include "support/temporary_folder.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <fstream>
#include <vector>

namespace edvo {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(PlyFile, HasAHeaderAndFifteenBytesPerPoint) {
  const test::TemporaryFolder folder;
  const std::vector<ColoredPoint> points = {{.position = {1, -2, 0.5F}, .rgb = {255, 128, 0}},
                                            {.position = {0, 0, 3}, .rgb = {1, 2, 3}}};
  write_ply(folder.path() / "points.ply", points);
  const std::string bytes = bytes_of(folder.path() / "points.ply");
  EXPECT_THAT(bytes, StartsWith("ply\nformat binary_little_endian 1.0\nelement vertex 2\n"));
  const std::string end = "end_header\n";
  const std::size_t begin = bytes.find(end) + end.size();
  ASSERT_EQ(bytes.size(), begin + 2 * 15);
  // 1, -2 and 0.5 as IEEE 754 numbers, lowest byte first.
  const unsigned char first[15] = {0, 0, 0x80, 0x3F, 0, 0, 0, 0xC0, 0, 0, 0, 0x3F, 255, 128, 0};
  EXPECT_EQ(std::memcmp(bytes.data() + begin, first, sizeof first), 0);
}

TEST(PlyFile, AMeshHasThirteenBytesPerTriangleBehindItsVertices) {
  const test::TemporaryFolder folder;
  const Mesh mesh{.vertices = std::vector<ColoredPoint>(3), .triangles = {{0, 2, 1}}};
  write_mesh(folder.path() / "mesh.ply", mesh);
  const std::string bytes = bytes_of(folder.path() / "mesh.ply");
  EXPECT_THAT(bytes, HasSubstr("element vertex 3\n"));
  EXPECT_THAT(bytes, HasSubstr("element face 1\nproperty list uchar int vertex_indices\n"));
  const unsigned char face[13] = {3, 0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0};
  ASSERT_GT(bytes.size(), sizeof face);
  EXPECT_EQ(std::memcmp(bytes.data() + bytes.size() - sizeof face, face, sizeof face), 0);
}

TEST(PlyFile, MayHoldNoPoint) {
  const test::TemporaryFolder folder;
  write_ply(folder.path() / "points.ply", {});
  EXPECT_THAT(bytes_of(folder.path() / "points.ply"), HasSubstr("element vertex 0\n"));
}

TEST(PlyFile, SaysWhichFileCannotBeWritten) {
  EXPECT_TRUE(test::fails_with(ErrorCode::kOutput, {"/no/such/points.ply"},
                               [] { write_ply("/no/such/points.ply", {}); }));
}

}  // namespace
}  // namespace edvo
