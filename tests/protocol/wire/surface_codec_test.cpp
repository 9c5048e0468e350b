// Messages with complete meshes must arrive unchanged or be refused.

#include <gtest/gtest.h>

#include "protocol/wire/control.hpp"
#include "tests/protocol/control_messages.hpp"

namespace feltwire::control {
namespace {

using test::round_trip;

SurfaceEntry surface_entry() {
  return {.surface = {.object = 7,
                      .pose = {Vec3(1, 2, 3), Quaternion(0.5, -0.5, 0.5, 0.5)},
                      .origin = Vec3(4, 5, 6),
                      .from_inside = true,
                      .double_sided = true,
                      .smooth = true,
                      .radius = 0.25,
                      .grain = 0.5,
                      .grain_wavelength = 2.0,
                      .vertices = {},
                      .triangles = {}},
          .vertices = 10,
          .triangles = 20};
}

TEST(Control, SurfacesInFull) {
  EXPECT_EQ(round_trip(ListSurfaces{5}).session, 5u);
  const SurfaceList list = round_trip(SurfaceList{3, {surface_entry(), surface_entry()}});
  EXPECT_EQ(list.version, 3u);
  ASSERT_EQ(list.surfaces.size(), 2u);
  const SurfaceEntry &sent = surface_entry(), &came = list.surfaces[1];
  EXPECT_EQ(came.surface.object, 7);
  EXPECT_EQ(came.surface.pose.position, sent.surface.pose.position);
  EXPECT_EQ(came.surface.pose.orientation.coeffs(), sent.surface.pose.orientation.coeffs());
  EXPECT_EQ(came.surface.origin, sent.surface.origin);
  EXPECT_TRUE(came.surface.from_inside && came.surface.double_sided && came.surface.smooth);
  EXPECT_EQ(came.surface.radius, 0.25);
  EXPECT_EQ(came.surface.grain, 0.5);
  EXPECT_EQ(came.surface.grain_wavelength, 2.0);
  EXPECT_EQ(came.vertices, 10u);
  EXPECT_EQ(came.triangles, 20u);
  const GetSurface get = round_trip(GetSurface{1, 2, 3, 4, 5});
  EXPECT_EQ(get.session, 1u);
  EXPECT_EQ(get.version, 2u);
  EXPECT_EQ(get.object, 3u);
  EXPECT_EQ(get.vertices, 4u);
  EXPECT_EQ(get.triangles, 5u);
  const SurfacePart full{std::vector<Vec3>(kMaxPart, Vec3(1, -2, 3e-9)),
                         std::vector<Triangle>(kMaxPart, Triangle{1, 2, 0xFFFFFFFF})};
  const SurfacePart part = round_trip(full);
  EXPECT_EQ(part.vertices, full.vertices);
  EXPECT_EQ(part.triangles, full.triangles);
  const TakeSurfaces take = round_trip(TakeSurfaces{1, 2, {3, 65535}});
  EXPECT_EQ(take.session, 1u);
  EXPECT_EQ(take.version, 2u);
  EXPECT_EQ(take.objects, (std::vector<std::uint16_t>{3, 65535}));
  EXPECT_EQ(round_trip(SurfacesTaken{9}).session, 9u);
}

TEST(Control, TooManySurfacesAreNoMessage) {
  const auto refused = [](const Message& message) {
    const std::vector<std::uint8_t> frame = encode(message);
    return !decode(Bytes(frame).subspan(kFrameLengthSize)).has_value();
  };
  EXPECT_FALSE(refused(SurfaceList{1, std::vector(kMaxSurfaces, surface_entry())}));
  EXPECT_TRUE(refused(SurfaceList{1, std::vector(kMaxSurfaces + 1, surface_entry())}));
  EXPECT_TRUE(refused(TakeSurfaces{1, 1, std::vector<std::uint16_t>(kMaxSurfaces + 1)}));
  EXPECT_TRUE(refused(SurfacePart{std::vector<Vec3>(kMaxPart + 1, Vec3::Zero()), {}}));
  EXPECT_TRUE(refused(SurfacePart{{}, std::vector<Triangle>(kMaxPart + 1)}));
}

}  // namespace
}  // namespace feltwire::control
