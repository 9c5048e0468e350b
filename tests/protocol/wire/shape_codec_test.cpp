#include <gtest/gtest.h>

#include "protocol/wire/control.hpp"
#include "tests/protocol/control_messages.hpp"

namespace feltwire::shape_codec_test {
namespace {

using control::DescribeShapes;
using control::GetShape;
using control::ShapeDescription;
using control::ShapeDescriptions;
using control::ShapeGroup;
using control::ShapePart;
using test::body;
using test::round_trip;

TEST(ShapeCodec, RequestsTravel) {
  const DescribeShapes list = round_trip(DescribeShapes{"room", ShapeGroup::guides, 7});
  EXPECT_EQ(list.scene, "room");
  EXPECT_EQ(list.group, ShapeGroup::guides);
  EXPECT_EQ(list.from, 7u);
  const GetShape get = round_trip(GetShape{"room", 2, ShapeGroup::tools, 3, 4, 5});
  EXPECT_EQ(get.scene, "room");
  EXPECT_EQ(get.version, 2u);
  EXPECT_EQ(get.group, ShapeGroup::tools);
  EXPECT_EQ(get.index, 3u);
  EXPECT_EQ(get.vertices, 4u);
  EXPECT_EQ(get.triangles, 5u);
  const auto unknown = static_cast<ShapeGroup>(3);
  EXPECT_FALSE(control::decode(body(control::encode(DescribeShapes{"room", unknown, 0}))));
  EXPECT_FALSE(control::decode(body(control::encode(GetShape{"room", 1, unknown, 0, 0, 0}))));
}

ShapeDescriptions list() {
  ShapeDescription brick;
  brick.name = "brick";
  brick.shape = "box";
  brick.lengths = {0.1, 0.2, 0.3};
  brick.pose = {{1.0, 2.0, 3.0}, Quaternion(0.6, 0.0, 0.0, 0.8)};
  brick.from_inside = true;
  brick.moves = true;
  brick.material = "wood";
  ShapeDescription path;
  path.name = "path";
  path.shape = "curve";
  path.parts = true;
  path.closed = true;
  path.action = "attract";
  return {.version = 4, .scene = "a room", .count = 9, .shapes = {brick, path}};
}

TEST(ShapeCodec, DescriptionsTravel) {
  const ShapeDescriptions got = round_trip(list());
  EXPECT_EQ(got.version, 4u);
  EXPECT_EQ(got.scene, "a room");
  EXPECT_EQ(got.count, 9u);
  ASSERT_EQ(got.shapes.size(), 2u);
  const ShapeDescription& brick = got.shapes[0];
  EXPECT_EQ(brick.name, "brick");
  EXPECT_EQ(brick.shape, "box");
  EXPECT_EQ(brick.lengths, (std::vector<double>{0.1, 0.2, 0.3}));
  EXPECT_EQ(brick.pose.position, Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(brick.pose.orientation.coeffs(), Quaternion(0.6, 0.0, 0.0, 0.8).coeffs());
  EXPECT_TRUE(brick.from_inside && brick.moves);
  EXPECT_FALSE(brick.parts || brick.closed);
  EXPECT_EQ(brick.material, "wood");
  EXPECT_EQ(brick.action, "");
  const ShapeDescription& path = got.shapes[1];
  EXPECT_EQ(path.action, "attract");
  EXPECT_EQ(path.material, "");
  EXPECT_TRUE(path.parts && path.closed);
  EXPECT_FALSE(path.from_inside || path.moves);
}

TEST(ShapeCodec, AListIsAsLongAsItMayBe) {
  ShapeDescriptions most = list();
  most.shapes.assign(control::kMaxShapes, most.shapes[0]);
  for (ShapeDescription& shape : most.shapes) {
    shape.name = shape.material = std::string(control::kMaxName, 'n');
    shape.lengths.resize(control::kMaxLengths);
  }
  most.scene = std::string(2 * control::kMaxReason, 's');
  EXPECT_EQ(round_trip(most).shapes.size(), control::kMaxShapes);  // and it fits into a frame
  EXPECT_EQ(round_trip(most).scene.size(), control::kMaxReason);
  ShapeDescriptions more = list();
  more.shapes.resize(control::kMaxShapes + 1);
  EXPECT_FALSE(control::decode(body(control::encode(more))));
  ShapeDescriptions longer = list();
  longer.shapes[0].lengths.resize(control::kMaxLengths + 1);
  EXPECT_FALSE(control::decode(body(control::encode(longer))));
  longer = list();
  longer.shapes[0].name = std::string(control::kMaxName + 1, 'n');
  EXPECT_FALSE(control::decode(body(control::encode(longer))));
}

TEST(ShapeCodec, PartsTravel) {
  ShapePart part{.all_vertices = 3000, .all_triangles = 5};
  part.vertices = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
  part.triangles = {{0, 1, 2}};
  const ShapePart got = round_trip(part);
  EXPECT_EQ(got.all_vertices, 3000u);
  EXPECT_EQ(got.all_triangles, 5u);
  EXPECT_EQ(got.vertices, part.vertices);
  EXPECT_EQ(got.triangles, part.triangles);
  part.vertices.resize(control::kMaxPart);
  part.triangles.resize(control::kMaxPart);
  EXPECT_EQ(round_trip(part).vertices.size(), control::kMaxPart);
  part.vertices.resize(control::kMaxPart + 1);
  EXPECT_FALSE(control::decode(body(control::encode(part))));
}

}  // namespace
}  // namespace feltwire::shape_codec_test
