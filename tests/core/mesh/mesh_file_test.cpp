#include "core/mesh/mesh_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "tests/core/mesh/mesh_error.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::mesh_file_test {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kSquareObj =
    "# a square\no square\nv -1 -1 0.5\nv 1 -1 0.5 1.0\r\nv\t+1 1 5e-1\nv -1 1 0.5\nvt 0 0\n"
    "vn 0 0 1\ns off\nf 1//1 2/1/1 -2 4/1\n";

void expect_square(const TriangleSoup& soup) {
  ASSERT_EQ(soup.triangles.size(), 2u);
  double area = 0.0;
  for (const Triangle& t : soup.triangles) {
    const std::array<Vec3, 3> c = {soup.vertices[t[0]], soup.vertices[t[1]], soup.vertices[t[2]]};
    EXPECT_EQ(triangle_normal(c), Vec3::UnitZ());
    for (const Vec3& v : c) EXPECT_EQ(v.z(), 0.5);
    area += 0.5 * (c[1] - c[0]).cross(c[2] - c[0]).norm();
  }
  EXPECT_DOUBLE_EQ(area, 4.0);
}

template <class T>
void append(std::string& bytes, T value, bool big = false) {
  std::array<char, sizeof value> raw{};
  std::memcpy(raw.data(), &value, sizeof value);
  if (big) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

std::string binary_stl() {
  std::string bytes(80, ' ');
  bytes.replace(0, 5, "solid");  // Some programs begin a binary file with this word.
  append(bytes, std::uint32_t{2});
  const std::array<std::array<float, 9>, 2> corners = {
      {{-1, -1, 0.5f, 1, -1, 0.5f, 1, 1, 0.5f}, {-1, -1, 0.5f, 1, 1, 0.5f, -1, 1, 0.5f}}};
  for (const auto& triangle : corners) {
    for (int i = 0; i < 3; ++i) append(bytes, 0.0f);
    for (const float x : triangle) append(bytes, x);
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string binary_ply(bool big) {
  std::string bytes =
      std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
      " 1.0\ncomment a square\nelement vertex 4\nproperty double x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty list uchar float extra\n"
      "element edge 1\nproperty int vertex1\n"
      "element face 1\nproperty list uchar ushort vertex_indices\nend_header\n";
  const std::array<std::array<double, 2>, 4> corners = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (const auto& c : corners) {
    append(bytes, c[0], big);
    append(bytes, static_cast<float>(c[1]), big);
    append(bytes, 0.5f, big);
    append(bytes, std::uint8_t{255});
    append(bytes, std::uint8_t{1});
    append(bytes, 3.0f, big);
  }
  append(bytes, std::int32_t{7}, big);
  append(bytes, std::uint8_t{4});
  for (std::uint16_t i = 0; i < 4; ++i) append(bytes, i, big);
  return bytes;
}

const std::string kTextPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "element face 1\nproperty list uchar int vertex_index\nend_header\n"
    "-1 -1 0.5\n1 -1 0.5\n1 1 0.5\n-1 1 0.5\n4 0 1 2 3\n";

const std::string kTextStl =
    "solid a square\nfacet normal 0 0 1\nouter loop\nvertex -1 -1 0.5\nvertex 1 -1 0.5\n"
    "vertex 1 1 0.5\nendloop\nendfacet\nfacet normal 0 0 1\n outer loop\n  vertex -1 -1 0.5\n"
    "  vertex 1 1 0.5\n  vertex -1 1 0.5\n endloop\nendfacet\nendsolid\n";

TEST(MeshFile, EveryFormatHoldsTheSameSquare) {
  expect_square(parse_mesh(kSquareObj, "square.obj", 1.0));
  expect_square(parse_mesh(kTextStl, "square.STL", 1.0));
  expect_square(parse_mesh(binary_stl(), "square.stl", 1.0));
  expect_square(parse_mesh(kTextPly, "square.ply", 1.0));
  expect_square(parse_mesh(binary_ply(false), "square.ply", 1.0));
  expect_square(parse_mesh(binary_ply(true), "square.ply", 1.0));
}

TEST(MeshFile, ScaleIsMetresPerUnitAndNoDigitIsLost) {
  const TriangleSoup soup =
      parse_mesh("v 1000000.123456789 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n", "a.obj", 1e-3);
  EXPECT_EQ(soup.vertices[0].x(), 1000000.123456789 * 1e-3);
}

TEST(MeshFile, WrittenAndReadAgainIsTheSame) {
  const TriangleSoup soup = test::icosphere(0.0937, 2);
  const TriangleSoup again = parse_mesh(obj_text(soup), "ball.obj", 1.0);
  EXPECT_EQ(again.vertices, soup.vertices);
  EXPECT_EQ(again.triangles, soup.triangles);
}

TEST(MeshFile, ErrorsNameFileLineAndRemedy) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_THAT(error_of(v + "f 1 2 4\n", "a.obj"),
              StartsWith("a.obj:4: face: vertex 4 does not exist, there are 3; "));
  EXPECT_THAT(error_of(v + "f 1 2 -4\n", "a.obj"), StartsWith("a.obj:4: face"));
  EXPECT_THAT(error_of(v + "f 1 2 0\n", "a.obj"), StartsWith("a.obj:4: face"));
  EXPECT_THAT(error_of(v + "f 1 2\n", "a.obj"), HasSubstr("three vertices, has 2"));
  EXPECT_THAT(error_of(v + "f 1 2 x\n", "a.obj"), HasSubstr("must be a whole number, is 'x'"));
  EXPECT_THAT(error_of("v 0 nan 0\n", "a.obj"),
              StartsWith("a.obj:1: v: must be a number, is 'nan'"));
  EXPECT_THAT(error_of("v 0 1e999 0\n", "a.obj"), StartsWith("a.obj:1: v: must be a number"));
  EXPECT_THAT(error_of("v 0 0\n", "a.obj"), HasSubstr("is missing"));
  EXPECT_THAT(error_of(v + "curv2 1 2\n", "a.obj"), StartsWith("a.obj:4: 'curv2'"));
  EXPECT_THAT(error_of(v, "a.obj"), HasSubstr("no triangle"));
  EXPECT_THAT(error_of("", "a.stl"), HasSubstr("within its header"));
  EXPECT_THAT(error_of(v, "a.fbx"), HasSubstr("give .obj, .stl or .ply"));
  EXPECT_THAT(error_of("solid x\nouter loop\nvertex 1 2\n", "a.stl"),
              StartsWith("a.stl:3: vertex"));
  EXPECT_THAT(error_of("solid x\nouter loop\nvertex 1 2 3\nendloop\n", "a.stl"),
              StartsWith("a.stl:4: endloop"));
  EXPECT_THAT(error_of("solid x\nvertex 1 2 3\n", "a.stl"),
              StartsWith("a.stl:2: vertex: stands outside"));
  EXPECT_THAT(error_of("ply\nformat funny 1.0\n", "a.ply"), StartsWith("a.ply:2: format"));
  EXPECT_THAT(error_of("ply\nformat ascii 1.0\nelement vertex -1\n", "a.ply"),
              StartsWith("a.ply:3: element"));
  std::string far = kTextPly;
  far.replace(far.rfind("2 3"), 3, "2 4");
  EXPECT_THAT(error_of(far, "a.ply"), StartsWith("a.ply:14: face"));
  EXPECT_THAT(error_of("PLY\n", "a.ply"), StartsWith("a.ply:1: "));
  EXPECT_THROW(read_mesh("/no/such/file.obj", 1.0), FileError);
}

/// Returns a square in every format with one coordinate `x`, and the coordinate's text.
std::vector<std::pair<std::string, std::string>> squares_with(double x) {
  const std::string text = std::to_string(static_cast<long long>(x));
  std::string stl = binary_stl();
  const auto raw = static_cast<float>(x);
  // x of the third corner of the first triangle
  std::memcpy(stl.data() + 84 + 12 + 24, &raw, sizeof raw);
  return {{"v -1 -1 0\nv 1 -1 0\nv " + text + " 1 0\nf 1 2 3\n", "far.obj"},
          {"solid\nouter loop\nvertex -1 -1 0\nvertex 1 -1 0\nvertex " + text +
               " 1 0\nendloop\nendsolid\n",
           "far.stl"},
          {stl, "binary.stl"},
          {"ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
           "property double z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
           "-1 -1 0\n1 -1 0\n" +
               text + " 1 0\n3 0 1 2\n",
           "far.ply"}};
}

// A scene extends to 1e6 m.
TEST(MeshFile, WhatIsFartherThanASceneReachesIsRefusedWhereItStands) {
  const std::vector<std::string> places = {
      "far.obj:3: ", "far.stl:5: ", "binary.stl: byte 120: ", "far.ply:12: "};
  for (const double scale : {1.0, 1e-3, 250.0}) {
    const auto inside = squares_with(std::floor(1e6 / scale));
    const auto outside = squares_with(-2e6 / scale);
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_NO_THROW(parse_mesh(inside[i].first, inside[i].second, scale)) << places[i];
      try {
        parse_mesh(outside[i].first, outside[i].second, scale);
        ADD_FAILURE() << places[i] << " is read at a scale of " << scale;
      } catch (const FileError& error) {
        EXPECT_THAT(error.what(),
                    ::testing::AllOf(StartsWith(places[i] + "vertex 3: x: "),
                                     HasSubstr("must lie within 1e+06 m"), HasSubstr("scale")));
      }
    }
  }
  EXPECT_THAT(error_of("v 0 0 0\nv 0 1e308 0\nv 0 0 1\nf 1 2 3\n", "a.obj"),
              StartsWith("a.obj:2: vertex 2: y: must lie within"));
}

TEST(MeshFile, ACoordinateOfAPlyFileThatIsAListIsRefused) {
  for (const std::string axis : {"x", "y", "z"}) {
    std::string ply = kTextPly;
    ply.replace(ply.find("property float " + axis), 16, "property list uchar float " + axis);
    const int line = 4 + (axis[0] - 'x');
    EXPECT_THAT(error_of(ply, "a.ply"), StartsWith("a.ply:" + std::to_string(line) + ": property " +
                                                   axis + ": is a list, must be one number"));
  }
}

TEST(MeshFile, ALineOfAnObjFileGoesOnAfterABackslash) {
  // The standard allows such breaks of long lines. The blank before the backslash may be missing.
  const std::string broken =
      "# a comment ends with its line \\\nv -1 -1 \\\n0.5\nv 1 \\\r\n -1\\\n0.5 \\\n 1.0\n"
      "v 1 1 0.5\nv -1 1 0.5\nvn 0 0 \\\n1\nusemtl \\\n\\\n red\nf 1//1 \\\n2/1/1\\\n -2\\\n 4/1\n";
  expect_square(parse_mesh(broken, "square.obj", 1.0));
  expect_square(parse_mesh(broken.substr(0, broken.size() - 1), "square.obj", 1.0));
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_THAT(error_of(v + "f 1 \\\n2 \\\n7\n", "a.obj"), StartsWith("a.obj:6: face: vertex 7"));
  EXPECT_THAT(error_of(v + "f 1 2 \\\n", "a.obj"), StartsWith("a.obj:4: f: a face needs three"));
  EXPECT_THAT(error_of(v + "f 1 2 3 # here \\\nq\n", "a.obj"), StartsWith("a.obj:5: 'q'"));
  EXPECT_THAT(error_of("v 0 0 0 \\ 1\n", "a.obj"), ::testing::Not(::testing::Eq("no error")));
}

TEST(MeshFile, BinaryFilesThatWereCutShortSaySoWhereverTheyEnd) {
  const std::string stl = binary_stl(), ply = binary_ply(false);
  for (std::size_t n = 0; n < stl.size(); ++n)
    EXPECT_NE(error_of(stl.substr(0, n), "a.stl"), "no error") << n;
  for (std::size_t n = 0; n < ply.size(); ++n)
    EXPECT_NE(error_of(ply.substr(0, n), "a.ply"), "no error") << n;
}

// Any file must give a surface or an error. No index may lack its vertex.
TEST(MeshFile, FilesWithBytesTurnedAreReadOrRefused) {
  std::mt19937 random(1);
  const std::vector<std::pair<std::string, std::string>> files = {
      {kSquareObj, "a.obj"}, {kTextStl, "a.stl"},          {binary_stl(), "b.stl"},
      {kTextPly, "a.ply"},   {binary_ply(false), "b.ply"}, {binary_ply(true), "c.ply"}};
  for (const auto& [bytes, name] : files)
    for (int n = 0; n < 3000; ++n) {
      std::string other = bytes;
      for (std::uint32_t k = 0; k <= n % 4u; ++k) {
        const std::size_t at = random() % other.size();
        if (random() % 3 == 0)
          other.erase(at, random() % 5);
        else
          other[at] = static_cast<char>(random());
        if (other.empty()) other = " ";
      }
      try {
        const TriangleSoup soup = parse_mesh(other, name, 1.0);
        for (const Triangle& t : soup.triangles)
          for (const std::uint32_t i : t) ASSERT_LT(i, soup.vertices.size());
        for (const Vec3& v : soup.vertices) ASSERT_TRUE(v.allFinite());
      } catch (const FileError&) {
      }
    }
}

}  // namespace
}  // namespace feltwire::mesh_file_test
