#pragma once
// A local model holds a hand on the side from which it came, as the scene does.

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "core/local_model/local_contact.hpp"
#include "core/local_model_extraction/extract.hpp"

namespace feltwire::test {

/// A point goes from height to height [m] above `base`, along the unit vector `out`, over a surface
/// of 1000 N/m at the height `surface`. At all heights the model made at the first one gives the
/// scene's force. So does a model made while the hand is held at `deep`, for a memory in which
/// the hand came from outside.
inline void expect_side_kept(const Scene& scene, const Vec3& base, const Vec3& out, double surface,
                             std::span<const double> heights, double deep) {
  TouchMemory memory = scene.memory();
  LocalContact local;
  const auto tool_at = [&](double height) { return Tool{base + height * out, Vec3::Zero()}; };
  for (const double height : heights) {
    const Tool tool = tool_at(height);
    const Command truth = scene.touch(tool, memory);
    if (height == heights.front()) {  // the later heights use the first model
      LocalModel model = local_model(scene, tool.position, memory);
      ASSERT_GE(model.count, 1);
      model.reach = 1.0;
      for (SurfacePatch& patch : model.patches) patch.radius = 1.0;
      local.take(model);
    }
    const LocalForce felt = local.touch(tool, 0.0, 1e-3);
    EXPECT_LT((felt.command.elastic - truth.elastic).norm(), 1e-9)
        << heights.front() << " " << height;
    EXPECT_NEAR(truth.elastic.dot(out), 1000.0 * std::max(0.0, surface - height), 1e-9);
  }
  scene.touch(tool_at(0.01), memory);
  const Tool below = tool_at(deep);
  const Command truth = scene.touch(below, memory);
  LocalContact other;
  other.take(local_model(scene, below.position, memory));
  EXPECT_LT((other.touch(below, 0.0, 1e-3).command.elastic - truth.elastic).norm(), 1e-9);
}

}  // namespace feltwire::test
