// Messages with a complete tool body and its solids must arrive unchanged or be refused.

#include <gtest/gtest.h>

#include "protocol/wire/control.hpp"
#include "protocol/wire/control_generated.h"
#include "tests/protocol/control_messages.hpp"

namespace feltwire::control {
namespace {

using test::round_trip;

BodyData heavy() {
  BodyData body;
  body.coupling = {1.0, 2.0, 3.0, 4.0};
  body.area = 5.0;
  body.contact_area = 6.0;
  body.inertia.mass = 7.0;
  body.inertia.center = {8, 9, 10};
  body.inertia.inertia << 11, 12, 13, 12, 14, 15, 13, 15, 16;
  body.inertia.gravity = {17, 18, 19};
  body.inertia.damping = 20.0;
  body.inertia.rotational_damping = 21.0;
  body.inertia.integration = ToolIntegration::midpoint;
  return body;
}

SolidData solid(const Shape& shape) {
  return {.object = 7,
          .shape = shape,
          .from_inside = true,
          .pose = {Vec3(1, 2, 3), Quaternion(0.5, -0.5, 0.5, 0.5)},
          .material = {.stiffness = 1.0,
                       .damping = 2.0,
                       .static_friction = 4.0,
                       .dynamic_friction = 3.0,
                       .viscous_friction = 5.0}};
}

/// Returns a solid of every shape. Each has different numbers.
std::vector<SolidData> solids() {
  std::vector<SolidData> all;
  Primitives::for_each([&](auto primitive) {
    double next = 0.1;
    primitive.lengths(primitive, [&](const Length&, double& length) { length = next += 0.1; });
    all.push_back(solid(primitive));
  });
  return all;
}

std::vector<double> lengths(const Shape& shape) {
  std::vector<double> numbers;
  on_primitive(
      shape,
      [&](const auto& primitive) {
        primitive.lengths(primitive,
                          [&](const Length&, double length) { numbers.push_back(length); });
      },
      [] {});
  return numbers;
}

TEST(Control, SolidsInFull) {
  EXPECT_EQ(round_trip(ListSolids{5}).session, 5u);
  const std::vector<SolidData> sent = solids();
  SolidList all{.version = 3, .body = heavy(), .points = 9};
  for (const SolidData& one : sent) all.solids.push_back({.solid = one});
  all.solids.push_back({.solid = solid({}), .vertices = 10, .triangles = 20});
  const SolidList list = round_trip(all);
  EXPECT_EQ(list.version, 3u);
  EXPECT_EQ(list.points, 9u);
  ASSERT_EQ(list.solids.size(), sent.size() + 1);
  EXPECT_EQ(list.solids.back().vertices, 10u);
  EXPECT_EQ(list.solids.back().triangles, 20u);
  for (std::size_t i = 0; i < sent.size(); ++i) {
    EXPECT_EQ(list.solids[i].triangles, 0u);
    const SolidData& came = list.solids[i].solid;
    EXPECT_EQ(came.object, 7);
    EXPECT_TRUE(came.from_inside);
    EXPECT_EQ(came.shape.index(), sent[i].shape.index());
    EXPECT_EQ(lengths(came.shape), lengths(sent[i].shape)) << i;
    EXPECT_EQ(came.pose.position, sent[i].pose.position);
    EXPECT_EQ(came.pose.orientation.coeffs(), sent[i].pose.orientation.coeffs());
    EXPECT_EQ(came.material.stiffness, 1.0);
    EXPECT_EQ(came.material.damping, 2.0);
    EXPECT_EQ(came.material.static_friction, 4.0);
    EXPECT_EQ(came.material.dynamic_friction, 3.0);
    EXPECT_EQ(came.material.viscous_friction, 5.0);
  }
  const GetBodyPoints get = round_trip(GetBodyPoints{1, 2, 3});
  EXPECT_EQ(get.session, 1u);
  EXPECT_EQ(get.version, 2u);
  EXPECT_EQ(get.points, 3u);
  const BodyPoints part{std::vector<Vec3>(kMaxPart, Vec3(1, -2, 3e-9))};
  EXPECT_EQ(round_trip(part).points, part.points);
}

TEST(Control, ABodyInFull) {
  const BodyData sent = heavy();
  const SolidList list = round_trip(SolidList{.version = 1, .body = sent});
  ASSERT_TRUE(list.body.has_value());
  const BodyData& came = *list.body;
  EXPECT_EQ(came.coupling.stiffness, 1.0);
  EXPECT_EQ(came.coupling.rotational_stiffness, 2.0);
  EXPECT_EQ(came.coupling.max_force, 3.0);
  EXPECT_EQ(came.coupling.max_torque, 4.0);
  EXPECT_EQ(came.area, 5.0);
  EXPECT_EQ(came.contact_area, 6.0);
  EXPECT_EQ(came.inertia.mass, 7.0);
  EXPECT_EQ(came.inertia.center, sent.inertia.center);
  EXPECT_EQ(came.inertia.inertia, sent.inertia.inertia);
  EXPECT_EQ(came.inertia.gravity, sent.inertia.gravity);
  EXPECT_EQ(came.inertia.damping, 20.0);
  EXPECT_EQ(came.inertia.rotational_damping, 21.0);
  EXPECT_EQ(came.inertia.integration, ToolIntegration::midpoint);
  EXPECT_FALSE(round_trip(SolidList{.version = 1}).body.has_value());
}

bool refused(const Message& message) {
  const std::vector<std::uint8_t> frame = encode(message);
  return !decode(Bytes(frame).subspan(kFrameLengthSize)).has_value();
}

TEST(Control, TooManySolidsAreNoMessage) {
  const auto many = [](std::size_t count) {
    return SolidList{.version = 1,
                     .solids = std::vector(count, SolidEntry{.solid = solid(Sphere{1.0})})};
  };
  EXPECT_FALSE(refused(many(kMaxSurfaces)));
  EXPECT_TRUE(refused(many(kMaxSurfaces + 1)));
  EXPECT_TRUE(refused(BodyPoints{std::vector<Vec3>(kMaxPart + 1, Vec3::Zero())}));
}

/// Decodes a list of a single solid with this name and these lengths. The body has mass. Unless
/// `whole` is set, the body lacks the inertia.
std::optional<Message> decoded(const char* shape, const std::vector<double>& lengths,
                               bool whole = true) {
  flatbuffers::FlatBufferBuilder builder;
  const wire::Vector zero(0, 0, 0);
  const wire::Turn unit(1, 0, 0, 0);
  const wire::FeltMaterial material(1, 0, 0, 0, 0);
  const auto name = builder.CreateString(shape);
  const auto numbers = builder.CreateVector(lengths);
  const auto entry =
      wire::CreateSolidEntry(builder, 0, &zero, &unit, false, &material, name, numbers);
  const auto entries = builder.CreateVector(&entry, 1);
  const auto inertia = builder.CreateVector(std::vector<double>{1, 1, 1, 0, 0, 0});
  const auto body =
      wire::CreateBodyEntry(builder, 1, 1, 1, 1, 1, 1, 1, 0.1, &zero, whole ? inertia : 0, &zero);
  const auto list = wire::CreateSolidList(builder, 1, body, entries);
  builder.Finish(wire::CreateControlMessage(builder, wire::Body::SolidList, list.Union()));
  return decode({builder.GetBufferPointer(), builder.GetSize()});
}

/// A newer server may send shapes that are unknown here. Such shapes must stay planes.
TEST(Control, AShapeThatIsNotKnownIsLeftOut) {
  const auto list = decoded("dodecahedron", {1.0});
  ASSERT_TRUE(list.has_value());
  EXPECT_TRUE(std::get<SolidList>(*list).solids.empty());
  EXPECT_EQ(std::get<SolidList>(*decoded("sphere", {1.0})).solids.size(), 1u);
}

TEST(Control, AShapeOrABodyWithoutAllOfItsNumbersIsNoMessage) {
  EXPECT_FALSE(decoded("sphere", {}).has_value());
  EXPECT_FALSE(decoded("sphere", {1.0, 2.0}).has_value());
  EXPECT_FALSE(decoded("box", {1.0, 2.0}).has_value());
  EXPECT_FALSE(decoded("mesh", {}).has_value());  // without triangles
  EXPECT_FALSE(decoded("sphere", {1.0}, false).has_value());
}

}  // namespace
}  // namespace feltwire::control
