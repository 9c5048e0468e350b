// Tests a height map: the closed form of a wave, no seams, constant images and bad images.

#include "core/mesh/height_map.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/file_error.hpp"
#include "core/contact/contact.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::height_map_test {
namespace {

using test::Random;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kPi = std::numbers::pi;
constexpr double kSize = 0.01, kAmplitude = 2e-4;  // [m]
constexpr int kPixels = 64;

/// Returns waves along the columns, from 0 to 1 and back over the width.
GreyImage wave() {
  GreyImage image{kPixels, 8, {}};
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      image.values.push_back(static_cast<float>(0.5 + 0.5 * std::sin(2.0 * kPi * x / kPixels)));
  return image;
}

Object sheet(std::shared_ptr<const HeightMap> map, const Grain& grain = {}) {
  Object o;
  o.name = "sheet";
  o.shape = Mesh{
      std::make_shared<MeshSurface>(TriangleMesh(test::sheet(0.1, 3)),
                                    MeshOptions{.grain = grain, .height_map = std::move(map)})};
  o.material.stiffness = 1000.0;
  return o;
}

Vec3 force_at(const Object& object, const Vec3& position) {
  ContactMemory memory;
  touch(object, {position + 0.01 * Vec3::UnitZ(), Vec3::Zero()}, memory);
  return touch(object, {position, Vec3::Zero()}, memory).elastic;
}

// The columns run along x on a surface with normal z. The cut is A (1 - sin) / 2, and the spring's
// energy is k (depth - cut)^2 / 2.
TEST(HeightMap, AWaveIsItsClosedForm) {
  const Object object = sheet(std::make_shared<HeightMap>(wave(), kAmplitude, kSize));
  constexpr double kDepth = 1e-3;
  // With this number of pixels, the spline reduces the amplitude of a wave to this fraction.
  const double kept = 1.0 - 0.5 * (kPi / kPixels) * (kPi / kPixels);
  for (int i = 0; i < 100; ++i) {
    const double x = -0.031 + 7.3e-4 * i, k = 2.0 * kPi / kSize;
    const Vec3 force = force_at(object, {x, 0.013, -kDepth});
    const double cut = 0.5 * kAmplitude * (1.0 - kept * std::sin(k * x));
    const double slope = -0.5 * kAmplitude * kept * k * std::cos(k * x);
    const double depth = kDepth - cut;
    EXPECT_NEAR(force.z(), 1000.0 * depth, 1e-3);
    EXPECT_NEAR(force.x(), 1000.0 * depth * slope, 1e-3);
    EXPECT_NEAR(force.y(), 0.0, 1e-6);
  }
}

TEST(HeightMap, RepeatsWithoutASeam) {
  Random random(1);
  GreyImage noise{16, 8, {}};
  for (int i = 0; i < 16 * 8; ++i) noise.values.push_back(static_cast<float>(random.uniform(0, 1)));
  const HeightMap map(noise, kAmplitude, kSize);
  const double height = kSize * 8 / 16;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), 0.0);
    const Relief here = map.at(p, Vec3::UnitZ());
    const Relief there = map.at(p + Vec3(3 * kSize, -2 * height, 0.0), Vec3::UnitZ());
    EXPECT_NEAR(here.cut, there.cut, 1e-12);
    EXPECT_LE((here.slope - there.slope).norm(), 1e-9);
    EXPECT_GE(here.cut, 0.0);
    EXPECT_LE(here.cut, kAmplitude * (1.0 + 1e-6));
    // Value and slope must be continuous across every pixel's edge, including the seam.
    for (const Vec3& edge :
         {Vec3(kSize, 0.013, 0.0), Vec3((i % 16 + 0.5) * kSize / 16, 0.02, 0.0)}) {
      const Vec3 step(1e-10, 0.0, 0.0);
      EXPECT_NEAR(map.at(edge - step, Vec3::UnitZ()).cut, map.at(edge + step, Vec3::UnitZ()).cut,
                  1e-10);
      EXPECT_LE(
          (map.at(edge - step, Vec3::UnitZ()).slope - map.at(edge + step, Vec3::UnitZ()).slope)
              .norm(),
          1e-6);
    }
    // The slope must be the gradient of the cut for any normal.
    const double d = 1e-7;
    const Vec3 normal = i % 2 == 0 ? Vec3::UnitZ() : random.direction();
    const Vec3 slope = map.at(p, normal).slope;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = d * Vec3::Unit(axis);
      EXPECT_NEAR((map.at(p + step, normal).cut - map.at(p - step, normal).cut) / (2 * d),
                  slope[axis], 1e-4);
    }
  }
}

// An image with a single grey value must give exactly the plain surface.
TEST(HeightMap, AConstantImageChangesNothing) {
  const Object plain = sheet(nullptr);
  for (const float grey : {0.0F, 0.3F, 1.0F}) {
    const Object flat = sheet(std::make_shared<HeightMap>(
        GreyImage{5, 3, std::vector<float>(15, grey)}, kAmplitude, kSize));
    Random random(2);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p(random.uniform(-0.09, 0.09), random.uniform(-0.09, 0.09), -1e-3);
      EXPECT_EQ(force_at(flat, p), force_at(plain, p));
    }
  }
}

// Each side of a body must show the image. Between the sides, the weights of the mixture must add
// up to 1.
TEST(HeightMap, LiesOnEverySideAlike) {
  const HeightMap map(wave(), kAmplitude, kSize);
  const double at = 0.0037;
  const double cut = map.at({at, 0.0, 5.0}, Vec3::UnitZ()).cut;
  EXPECT_DOUBLE_EQ(map.at({7.0, at, 0.0}, -Vec3::UnitX()).cut, cut);
  EXPECT_DOUBLE_EQ(map.at({0.0, 3.0, at}, Vec3::UnitY()).cut, cut);
  EXPECT_NEAR(map.at(Vec3::Constant(at), Vec3(1, 1, 1).normalized()).cut, cut, 1e-15);
}

// Above the bottom of the relief nothing must hold a hand. No force may pull, and no call may
// allocate.
TEST(HeightMap, IsCutIntoTheSurface) {
  const Object object = sheet(std::make_shared<HeightMap>(wave(), kAmplitude, kSize));
  const double valley = 0.75 * kSize, ridge = 0.25 * kSize;
  EXPECT_TRUE(force_at(object, {valley, 0.0, -0.9 * kAmplitude}).isZero(0.0));
  EXPECT_NEAR(force_at(object, {ridge, 0.0, -0.9 * kAmplitude}).z(), 0.18, 2e-3);
  ContactMemory memory;
  touch(object, {Vec3(0.0, 0.0, 0.01), Vec3::Zero()}, memory);
  const std::size_t before = test::allocations();
  for (int i = 0; i < 1000; ++i)
    EXPECT_GE(touch(object, {Vec3(5e-5 * i, 0.01, -2e-4), Vec3::Zero()}, memory).elastic.z(), 0.0);
  EXPECT_EQ(test::allocations(), before);
}

std::string error_of_pgm(std::string_view bytes) {
  try {
    parse_pgm(bytes, "a.pgm");
  } catch (const FileError& error) {
    return error.what();
  }
  return "no error";
}

TEST(HeightMap, ReadsPgmOfEightAndSixteenBitsAndText) {
  const std::string eight("P5\n# by hand\n2 1\n255\n\x00\xFF", 23);
  EXPECT_EQ(parse_pgm(eight, "a.pgm").values, (std::vector<float>{0.0F, 1.0F}));
  const std::string sixteen("P5 1 2 65535 \xFF\xFF\x80\x00", 17);
  EXPECT_EQ(parse_pgm(sixteen, "a.pgm").values, (std::vector<float>{1.0F, 32768.0F / 65535.0F}));
  const GreyImage text = parse_pgm("P2 3 2 10\n0 5 10\n10 5 # last\n0\n", "a.pgm");
  EXPECT_EQ(text.width, 3);
  EXPECT_EQ(text.height, 2);
  EXPECT_EQ(text.values[1], 0.5F);
}

TEST(HeightMap, RefusesBadPicturesWithTheByte) {
  EXPECT_THAT(error_of_pgm("\x89PNG"), HasSubstr("a.pgm: byte 0: is no portable graymap"));
  EXPECT_THAT(error_of_pgm(""), HasSubstr("save it as PGM"));
  EXPECT_THAT(error_of_pgm("P5 0 4 255 "),
              HasSubstr("byte 3: width must be a number from 1 to 8192"));
  EXPECT_THAT(error_of_pgm("P5 99999999999 4 255 "), HasSubstr("width must be"));
  EXPECT_THAT(error_of_pgm("P5 4 4 70000 "), HasSubstr("largest grey must be"));
  EXPECT_THAT(error_of_pgm("P5 2 2 255 abc"), HasSubstr("it ends before its pixels do"));
  EXPECT_THAT(error_of_pgm("P5 1 1 100 \xFF"), HasSubstr("brighter than its white, 100"));
  EXPECT_THAT(error_of_pgm("P2 2 1 10 3"), HasSubstr("it ends before its grey"));
  EXPECT_THAT(error_of_pgm("P2 2 1 10 3 -4"), HasSubstr("grey must be a number from 0 to 10"));
  const std::string good = "P5 # x\n3 2\n255\nabcdef";
  EXPECT_EQ(error_of_pgm(good), "no error");
  for (std::size_t size = 0; size < good.size(); ++size)  // The file is cut at each byte.
    EXPECT_NE(error_of_pgm(good.substr(0, size)), "no error") << size;
}

}  // namespace
}  // namespace feltwire::height_map_test
