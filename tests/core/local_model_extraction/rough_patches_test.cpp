// The local model of a mesh with a texture has the mean surface, and the texture from the reply at
// the tool's position.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/height_map.hpp"
#include "tests/support/followed_hand.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::rough_patches_test {
namespace {

constexpr double kStiffness = 1000.0;                    // [N/m]
constexpr double kAmplitude = 2e-4, kWavelength = 0.02;  // [m]
constexpr double kDepth = 1e-3;                          // [m]

constexpr double kFloat = 1e-8;  // [N] The texture samples have single precision.

/// Returns waves along x, from the surface down to kAmplitude below.
MeshOptions waves() {
  constexpr int kPixels = 64;
  GreyImage image{kPixels, 1, {}};
  for (int x = 0; x < kPixels; ++x)
    image.values.push_back(
        static_cast<float>(0.5 + 0.5 * std::sin(2.0 * std::numbers::pi * x / kPixels)));
  return {.height_map = std::make_shared<HeightMap>(image, kAmplitude, kWavelength)};
}

Scene sheet(const MeshOptions& options) {
  return Scene("s", {test::mesh_object(test::sheet(0.1, 4), options, {.stiffness = kStiffness})});
}

LocalModel model_at(const Scene& scene, const Vec3& position, TouchMemory& memory) {
  scene.touch({position + 0.01 * Vec3::UnitZ(), Vec3::Zero()}, memory);
  scene.touch({position, Vec3::Zero()}, memory);
  return local_model(scene, position, memory);
}

TEST(RoughPatches, AreTheMeanSurface) {
  for (const auto& [options, mean] :
       {std::pair{waves(), 0.5 * kAmplitude}, std::pair{MeshOptions{.grain = {1e-4, 1e-3}}, 1e-4},
        std::pair{MeshOptions{.radius = 2e-3, .grain = {1e-4, 1e-3}}, 1e-4}}) {
    const Scene scene = sheet(options);
    TouchMemory memory = scene.memory();
    const LocalModel model = model_at(scene, Vec3(0.013, 0.02, options.radius - kDepth), memory);
    ASSERT_EQ(model.count, 1);
    EXPECT_TRUE(model.patches[0].rough);
    EXPECT_NEAR(model.patches[0].offset, options.radius - mean, 1e-9);
    EXPECT_TRUE(model.patches[0].point.isApprox(Vec3(0.013, 0.02, 0.0)));
    EXPECT_GT(model.reach, 0.05);
  }
}

// At the tool's old position the model must equal the scene, up to rounding. Elsewhere it gives the
// mean surface and the texture of the old position. The texture fades with decreasing depth.
TEST(RoughPatches, GiveTheTextureOfWhereTheToolWas) {
  const Scene scene = sheet(waves());
  for (const double x : {0.0, 0.003, 0.007, 0.012, 0.0161}) {
    TouchMemory memory = scene.memory();
    const Vec3 was(x, 0.0, -kDepth);
    const LocalModel model = model_at(scene, was, memory);
    const Command answered = scene.touch({was, Vec3::Zero()}, memory);
    LocalContact local;
    local.take(model, &answered);
    EXPECT_LE(
        (local.touch({was, Vec3::Zero()}, 0.0, 1e-3).command.elastic - answered.elastic).norm(),
        1e-12);
    const Vec3 texture =
        answered.elastic - kStiffness * (kDepth - 0.5 * kAmplitude) * Vec3::UnitZ();
    EXPECT_GT(texture.norm(), 0.02);
    for (const double depth : {1.5 * kDepth, kDepth, 0.5 * kDepth, 0.15 * kDepth, 0.05 * kDepth}) {
      const Vec3 elastic =
          local.touch({Vec3(0.05, 0.0, -depth), Vec3::Zero()}, 0.0, 1e-3).command.elastic;
      const double mean = depth - 0.5 * kAmplitude, share = mean / (kDepth - 0.5 * kAmplitude);
      const Vec3 expected =
          mean > 0.0 ? Vec3(kStiffness * mean * Vec3::UnitZ() + std::min(1.0, share) * texture)
                     : Vec3::Zero();
      EXPECT_LE((elastic - expected).norm(), kFloat) << depth;
      EXPECT_GE(elastic.z(), 0.0);
    }
    local.take(model);  // Without a reply the model has only the mean surface.
    EXPECT_NEAR(local.touch({was, Vec3::Zero()}, 0.0, 1e-3).command.elastic.z(),
                kStiffness * (kDepth - 0.5 * kAmplitude), kFloat);
  }
}

// A surface without texture must equal the scene for any reply.
TEST(RoughPatches, OnlyRoughOnesHaveATexture) {
  const Scene scene = sheet({});
  TouchMemory memory = scene.memory();
  const Vec3 was(0.0, 0.0, -kDepth);
  const LocalModel model = model_at(scene, was, memory);
  EXPECT_FALSE(model.patches[0].rough);
  LocalContact local;
  const Command answered{.elastic = Vec3(3.0, 0.0, 0.0)};
  local.take(model, &answered);
  EXPECT_LE((local.touch({was, Vec3::Zero()}, 0.0, 1e-3).command.elastic -
             kStiffness * kDepth * Vec3::UnitZ())
                .norm(),
            1e-12);
}

// A hand slides over a coarse relief with a model every 20 ms. The error must be at most the change
// of the texture within 20 ms.
TEST(RoughPatches, AGlideErrsByTheTexturesChangeAlone) {
  const Scene scene = sheet(waves());
  test::FollowedHand hand(scene, 20);
  const double speed = 0.05;  // [m/s]
  const auto at = [&](int n) {
    return Vec3(-0.07 + 1e-3 * speed * n, 0.0, -kDepth - 5e-4 * std::sin(0.02 * n));
  };
  hand.approach({at(0) + 0.01 * Vec3::UnitZ(), Vec3::Zero()});
  double worst = 0.0;
  int spoke = 0;
  for (int n = 0; n < 2500; ++n) {
    if (!hand.step({at(n), Vec3::Zero()})) continue;
    ++spoke;
    worst = std::max(worst, hand.error());
  }
  EXPECT_GT(spoke, 2400);
  // 1 mm of movement along the steepest part of the wave, doubled for the change of depth.
  const double slope = std::numbers::pi * kAmplitude / kWavelength;
  EXPECT_LT(worst, 2.0 * kStiffness * slope * 1e-3);
  EXPECT_GT(worst, 0.2 * kStiffness * slope * 1e-3);
}

}  // namespace
}  // namespace feltwire::rough_patches_test
