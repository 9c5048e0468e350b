// Two surfaces must never have the same identifier. The contact memory of one must not apply to
// another.

#include <gtest/gtest.h>

#include <map>

#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/local_model_extraction/fitted_patches.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::surface_id_test {
namespace {

constexpr double kHalf = 0.02, kApart = 0.1;  // [m]
constexpr int kBoxes = 60;
const Material kRough{.stiffness = 1000.0, .static_friction = 0.5, .dynamic_friction = 0.4};

/// Boxes in a row as one mesh. Their faces have six normals and 360 planes.
Object boxes() {
  TriangleSoup soup;
  for (int i = 0; i < kBoxes; ++i)
    soup = test::joined(std::move(soup), test::moved(test::box(Vec3::Constant(kHalf), 2),
                                                     Vec3(kApart * i, 0.0, 0.0)));
  return test::mesh_object(soup, {}, kRough);
}

TEST(SurfaceId, NoTwoFacesOfAMeshShareOne) {
  const Object object = boxes();
  std::map<std::uint32_t, std::pair<int, int>> whose;
  for (int i = 0; i < kBoxes; ++i)
    for (int face = 0; face < 6; ++face)
      for (const double off : {-0.011, 0.007}) {  // on several triangles of the same face
        const Vec3 out = (face % 2 == 0 ? 1.0 : -1.0) * Vec3::Unit(face / 2);
        const Vec3 place = Vec3(kApart * i, 0.0, 0.0) + (kHalf + 0.001) * out +
                           off * Vec3::Unit((face / 2 + 1) % 3);
        const FittedPatches fitted = fitted_patches(object, place, {}, 0.0, false);
        ASSERT_GT(fitted.count, 0);
        const FittedPatch& nearest = fitted.patches[0];
        ASSERT_LT((nearest.normal - out).norm(), 1e-9);
        const auto [known, first] = whose.try_emplace(nearest.feature, i, face);
        EXPECT_EQ(known->second, std::pair(i, face)) << "feature " << nearest.feature;
      }
  EXPECT_EQ(whose.size(), 6u * kBoxes);
}

Tool on_box(int i, double x, double height) {
  return {{kApart * i + x, 0.0, kHalf + height}, Vec3::Zero()};
}

TEST(SurfaceId, AFacetThatTheModelNoLongerHasLeavesNoStickPoint) {
  const Scene scene("s", {boxes()});
  for (int to = 1; to < kBoxes; to += 7) {
    TouchMemory memory = scene.memory();
    LocalContact local;
    scene.touch(on_box(0, 0.017, 1e-3), memory);
    const LocalModel first = local_model(scene, on_box(0, 0.017, 1e-3).position, memory);
    ASSERT_TRUE(first.patches[0].joined);  // top and side
    local.take(first);
    local.touch(on_box(0, 0.017, 1e-3), 0.0, 1e-3);
    ASSERT_GT(local.touch(on_box(0, 0.017, -5e-4), 0.0, 1e-3).command.elastic.z(), 0.4);

    // The server's tool is on another box meanwhile.
    for (const double height : {1e-3, 1e-3, -5e-4}) scene.touch(on_box(to, 0.017, height), memory);
    const Tool tool = on_box(to, 0.0171, -5e-4);
    const Command truth = scene.touch(tool, memory);
    EXPECT_NEAR(truth.frictional.x(), -1000.0 * 1e-4, 1e-9);
    local.take(local_model(scene, tool.position, memory));
    const Command felt = local.touch(tool, 0.0, 1e-3).command;
    EXPECT_LT((felt.force() - truth.force()).norm(), 1e-9) << to;
  }
}

// A reload brings other objects with the same names.
TEST(SurfaceId, AnotherSceneTakesNothingOver) {
  Object block;
  block.name = "block";
  block.shape = Box{Vec3::Constant(kHalf)};
  block.material = kRough;
  const Scene scene("s", {block});
  for (const std::uint32_t reloaded : {0u, 1u}) {
    LocalContact local;
    LocalModel model = local_model(scene, on_box(0, 0.0, 1e-3).position, scene.memory());
    local.take(model);
    local.touch(on_box(0, 0.0, 1e-3), 0.0, 1e-3);
    local.touch(on_box(0, 0.0, -5e-4), 0.0, 1e-3);
    model.scene += reloaded;
    local.take(model);
    const Command felt = local.touch(on_box(0, 1e-4, -5e-4), 0.0, 1e-3).command;
    EXPECT_NEAR(felt.frictional.x(), reloaded != 0 ? 0.0 : -0.1, 1e-9);
  }
}

}  // namespace
}  // namespace feltwire::surface_id_test
