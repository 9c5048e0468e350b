// Tests mesh files in the format of other programs, and other files with a mesh file's name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/base/file_error.hpp"
#include "core/mesh/height_map.hpp"
#include "core/mesh/mesh_file.hpp"
#include "tests/core/mesh/mesh_error.hpp"

namespace feltwire::foreign_mesh_test {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kMark = "\xEF\xBB\xBF";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

std::string in_capitals(std::string text) {
  for (char& c : text) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return text;
}

/// Returns texts that are written differently but have one meaning.
std::vector<std::string> written_otherwise(const std::string& text) {
  return {kMark + text,
          "\n\n" + text,
          " \t\r\n" + text,
          std::string(kMark) + "\r\n" + text,
          replaced(text, "\n", "\r\n"),
          replaced(text, "\n", "\r"),
          replaced(text, " ", "\t"),
          replaced(text, " ", "  \t "),
          in_capitals(text),
          kMark + replaced(in_capitals(text), "\n", "\r\n") + "\r\n\r\n"};
}

void expect_triangle(const std::string& bytes, const std::string& name) {
  SCOPED_TRACE(name + ": " + bytes.substr(0, 60));
  TriangleSoup soup;
  ASSERT_NO_THROW(soup = parse_mesh(bytes, name, 1.0)) << error_of(bytes, name);
  ASSERT_EQ(soup.triangles.size(), 1u);
  const Triangle t = soup.triangles[0];
  EXPECT_EQ(soup.vertices[t[0]], Vec3(0, 0, 0));
  EXPECT_EQ(soup.vertices[t[1]], Vec3(2, 0, 0));
  EXPECT_EQ(soup.vertices[t[2]], Vec3(0, 3, 0.5));
}

const std::string kObj = "v 0 0 0\nv 2 0 0\nv 0 3 0.5\nf 1 2 3\n";
const std::string kStl =
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 3 "
    "0.5\nendloop\nendfacet\nendsolid x\n";
const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n0 3 "
    "0.5\n3 0 1 2\n";

TEST(ForeignMesh, CapitalsMarksBlankLinesAndLineEndsDoNotMatter) {
  for (const std::string& text : written_otherwise(kObj)) expect_triangle(text, "a.obj");
  for (const std::string& text : written_otherwise(kStl)) expect_triangle(text, "a.stl");
  for (const std::string& text : written_otherwise(kPly)) expect_triangle(text, "a.ply");
  expect_triangle("# a comment\n" + kObj, "a.OBJ");
  expect_triangle("# a comment\n; another\n\n" + kStl, "a.STL");
  expect_triangle("# a comment\n" + kPly, "a.PLY");
}

TEST(ForeignMesh, FacesMayStandBeforeTheirVertices) {
  expect_triangle("f 1 2 3\nv 0 0 0\nv 2 0 0\nv 0 3 0.5\n", "a.obj");
  expect_triangle("v 0 0 0\nf -1 2 3\nv 2 0 0\nv 0 3 0.5\n", "a.obj");
  EXPECT_THAT(error_of("v 0 0 0\nf 1 2 3\nf 1 2 9\nf 1 2 4\nv 0 0 0\nv 0 1 0\n", "a.obj"),
              StartsWith("a.obj:3: face: vertex 9 does not exist, there are 3; "));
  expect_triangle(
      "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
      "element vertex 3\nproperty float z\nproperty float x\nproperty float y\nend_header\n"
      "3 0 1 2\n0 0 0\n0 2 0\n0.5 0 3\n",
      "a.ply");
  EXPECT_THAT(
      error_of(
          "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
          "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
          "3 0 1 3\n0 0 0\n2 0 0\n0 3 0.5\n",
          "a.ply"),
      StartsWith("a.ply:10: face: a vertex does not exist among the 3"));
}

std::string binary_stl(const std::string& header) {
  std::string bytes = header;
  bytes.resize(80, ' ');
  const std::uint32_t count = 1;
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (const float x : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 0.f, 3.f, 0.5f})
    bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
  return bytes.append(2, '\0');
}

TEST(ForeignMesh, ABinaryStlIsOneWhateverItsHeaderSays) {
  for (const std::string header :
       {"solid part", "SOLID facet normal", "", "#", "\xEF\xBB\xBFsolid"}) {
    expect_triangle(binary_stl(header), "a.stl");
    expect_triangle(binary_stl(header) + "trailing bytes", "a.stl");
    const std::string cut = binary_stl(header);
    EXPECT_THAT(error_of(cut.substr(0, cut.size() - 9), "a.stl"), HasSubstr("it was cut short"));
  }
}

TEST(ForeignMesh, StlWordsMayShareALine) {
  expect_triangle(
      "solid\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 2 0 0 vertex 0 3 0.5 endloop "
      "endfacet\nendsolid",
      "a.stl");
  expect_triangle(replaced(kStl, "outer loop", "outer\nloop"), "a.stl");
}

TEST(ForeignMesh, WhatStandsInPlaceOfAFileIsNamedWithItsRemedy) {
  const std::string lfs =
      "version https://git-lfs.github.com/spec/v1\noid sha256:094d\nsize 625707\n";
  for (const char* name : {"a.obj", "a.stl", "a.ply"}) {
    EXPECT_THAT(error_of(lfs, name),
                AllOf(StartsWith(std::string(name) + ": is a pointer of Git LFS"),
                      HasSubstr("git lfs pull")));
    EXPECT_THAT(error_of(kMark + replaced(lfs, "\n", "\r\n"), name), HasSubstr("git lfs pull"));
    EXPECT_THAT(error_of("../.git/annex/objects/Xk/9M/SHA256E-s6.stl\n", name),
                HasSubstr("git annex get"));
    EXPECT_THAT(error_of("\n\n<!DOCTYPE html>\n<html lang=\"en\">", name),
                HasSubstr("is a web page"));
    EXPECT_THAT(error_of("<HTML><head>", name), HasSubstr("is a web page"));
    EXPECT_THAT(error_of("\x1F\x8B\x08rest", name), HasSubstr("gunzip"));
    EXPECT_THAT(error_of("PK\x03\x04rest", name), HasSubstr("is a zip archive"));
    EXPECT_THAT(error_of(std::string("\xFF\xFEv\0", 4), name), HasSubstr("UTF-16"));
  }
  EXPECT_THAT(error_of(kPly, "a.stl"), HasSubstr("is a PLY file by its first word"));
  EXPECT_THAT(error_of(kStl, "a.obj"), HasSubstr("is an STL file by its first word"));
  EXPECT_THAT(error_of("v 0,5 0 0\n", "a.obj"), HasSubstr("with a decimal point"));
}

TEST(ForeignMesh, HeightMapsLikewise) {
  const std::string pgm = "P2\n2 1\n255\n0 255\n";
  for (const std::string& text :
       {kMark + pgm, "\n# first\n" + pgm, replaced(pgm, "\n", "\r\n"), replaced(pgm, " ", "\t")})
    EXPECT_EQ(parse_pgm(text, "a.pgm").width, 2) << text;
  try {
    parse_pgm("version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 2\n", "a.pgm");
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), AllOf(StartsWith("a.pgm: "), HasSubstr("git lfs pull")));
  }
}

}  // namespace
}  // namespace feltwire::foreign_mesh_test
