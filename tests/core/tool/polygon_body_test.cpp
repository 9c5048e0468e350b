// Tests a polygonal tool: closed forms, pegs, thin walls, and malicious hands.

#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/tessellation.hpp"
#include "core/tool/body_tool.hpp"
#include "tests/core/polyhedra/solids.hpp"
#include "tests/support/same_twice.hpp"

namespace feltwire::polygon_body_test {
namespace {

constexpr double kStiffness = 1000.0;  // [N/m]
const Vec3 kHalf(0.03, 0.02, 0.01);
constexpr double kFace = 4.0 * 0.03 * 0.02;  // [m^2]
const Quaternion kUpright = Quaternion::Identity();

using test::box_corners;
using Corners = std::vector<Vec3>;

Object object(const Vec3& position = Vec3::Zero()) {
  Object o;
  o.name = "o";
  o.shape = Plane{};  // The shape is unused, because the tool has the solids.
  o.pose.position = position;
  o.material.stiffness = kStiffness;
  return o;
}

SolidParts box(const Vec3& half) { return solid_parts(Box{half}, Side::outside); }

BodyTool tool(const std::vector<Corners>& parts, std::vector<SolidParts> solids,
              const ToolCoupling& coupling = {}, double area = kFace) {
  return {point_shell(tessellate(Box{kHalf}, 3), 100),
          coupling,
          area,
          {},
          std::make_shared<const PolygonBody>(polygon_body(parts, std::move(solids)))};
}

BodyStep step(const BodyTool& body, const std::vector<Object>& objects, const Pose& device,
              BodyMemory& memory) {
  return step_body(body, objects, device, 1e-3, memory);
}

double coupling_energy(const BodyTool& body, const Pose& at, const Pose& device) {
  const ToolCoupling& k = body.coupling();
  const auto energy = [](double x, double stiffness, double most) {
    return x < most / stiffness ? 0.5 * stiffness * x * x : most * (x - 0.5 * most / stiffness);
  };
  return energy((device.position - at.position).norm(), k.stiffness, k.max_force) +
         energy(rotation_between(at.orientation, device.orientation).norm(), k.rotational_stiffness,
                k.max_torque);
}

Quaternion about(const Vec3& axis, double angle) {
  return Quaternion(Eigen::AngleAxisd(angle, axis));
}

// Two springs in series. A face of area A_c has the material's stiffness. A quarter of this area
// has half the stiffness.
TEST(PolygonBody, AFlatFaceIsASpring) {
  for (const double share : {1.0, 0.25}) {
    const BodyTool body = tool({box_corners(kHalf)}, {box(Vec3(0.1, 0.1, 0.05))},
                               {.stiffness = 500.0, .max_force = 3.0}, kFace / share);
    const double k = kStiffness * std::sqrt(share);
    BodyMemory memory;
    const std::vector<Object> objects = {object()};
    step(body, objects, {Vec3(0, 0, 0.061), kUpright}, memory);
    for (double d = 1e-4; d < 0.01; d += 1e-4) {
      BodyStep now;
      for (int i = 0; i < 3; ++i)
        now = step(body, objects, {Vec3(0, 0, 0.06 - d), kUpright}, memory);
      const double force = std::min(3.0, d / (1.0 / 500.0 + 1.0 / k));
      EXPECT_NEAR(now.command.elastic.z(), force, 1e-3 * force) << d;
      EXPECT_LT(now.command.torque.norm(), 1e-6);
      EXPECT_EQ(now.touching, 1u);
    }
  }
}

TEST(PolygonBody, ClearanceIsNoLie) {
  const PolygonBody body = polygon_body({box_corners(kHalf)}, {box(Vec3::Constant(0.02))});
  const std::vector<Object> objects = {object()};
  test::Random random(4);
  int near_ones = 0;
  for (int i = 0; i < 200; ++i) {
    // A rotation about z, the axis through tool and box, does not change the gap.
    const double gap = random.chance(0.5) ? random.uniform(1e-5, 5e-3) : random.uniform(0.0, 0.5);
    const Pose pose{Vec3(0, 0, 0.03 + gap), about(Vec3::UnitZ(), random.uniform(-3, 3))};
    PartPairs near;
    update_part_pairs(body, objects, pose, true, near);
    const double clear = polygon_contact(body, objects, kFace, near, pose).clearance;
    EXPECT_LE(clear, gap + 1e-12);
    EXPECT_EQ(clear, clearance(near));
    if (gap < kNearPairs) {
      ++near_ones;
      EXPECT_GT(clear, (1.0 - 1e-6) * gap);
    }
  }
  EXPECT_GT(near_ones, 50);
}

TEST(PolygonBody, AStepNeverAddsEnergy) {
  const std::vector<Corners> wedge_and_bar = {
      box_corners(Vec3(0.02, 0.004, 0.004)),
      {Vec3(0.02, 0.01, 0.004), Vec3(0.02, -0.01, 0.004), Vec3(0.02, 0.01, -0.004),
       Vec3(0.02, -0.01, -0.004), Vec3(0.04, 0, 0)}};
  const BodyTool body =
      tool(wedge_and_bar,
           {box(Vec3::Constant(0.02)), solid_parts(Plane{}, Side::outside),
            box(Vec3(0.03, 0.03, 1e-4)), solid_parts(Sphere{0.015}, Side::outside),
            solid_parts({box_corners(Vec3(0.02, 0.02, 0.005)),
                         box_corners(Vec3(0.005, 0.02, 0.01), Vec3(0.015, 0, 0.015))})},
           {.stiffness = 2000.0}, 1e-4);
  std::vector<Object> objects = {object(Vec3(0.03, 0, 0)), object(Vec3(0, 0, -0.03)),
                                 object(Vec3(0, 0, 0.04)), object(Vec3(-0.03, 0.01, 0)),
                                 object(Vec3(0, 0.05, 0.01))};
  objects[2].pose.orientation = about(Vec3(1, 1, 0).normalized(), 0.5);
  objects[0].material.static_friction = objects[0].material.dynamic_friction = 0.4;
  objects[1].material.damping = 5.0;
  BodyMemory memory;
  test::Random random(3);
  Pose device{Vec3(0, 0, 0.02), kUpright};
  BodyStep last = step(body, objects, device, memory);
  std::size_t touched = 0;
  for (int i = 0; i < 6000; ++i) {
    const Pose before = device;
    device = moved(device, random.vector(-6.0, -2.3), random.vector(-4.0, -1.0));
    if (device.position.norm() > 0.07) device = before;
    const double worked =
        coupling_energy(body, memory.pose, device) - coupling_energy(body, memory.pose, before);
    const BodyStep now = step(body, objects, device, memory);
    // A redirected pair changes its depth integral V by the fraction kSameDepth at most.
    ASSERT_LE(now.stored, last.stored * (1.0 + 1e-9) + worked + 1e-12) << i;
    touched += now.touching > 0 ? 1 : 0;
    last = now;
  }
  EXPECT_GT(touched, 3000u);
}

TEST(PolygonBody, TheWrenchIsTheGradientOfTheEnergy) {
  const PolygonBody body =
      polygon_body({box_corners(kHalf), box_corners(Vec3(0.005, 0.005, 0.02), Vec3(0, 0, -0.02))},
                   {solid_parts({box_corners(Vec3(0.02, 0.02, 0.005)),
                                 box_corners(Vec3(0.005, 0.02, 0.01), Vec3(0.015, 0, 0.015))}),
                    solid_parts(Cylinder{0.02, 0.01}, Side::outside)});
  std::vector<Object> objects = {object(Vec3(0.1, 0.2, 0.3)), object(Vec3(0.1, 0.17, 0.3))};
  objects[1].pose.orientation = about(Vec3(1, 2, 3).normalized(), 1.0);
  test::Random random(8);
  int touching = 0;
  for (int i = 0; i < 100; ++i) {
    const Pose pose{Vec3(0.1, 0.2, 0.3) + random.uniform(0.0, 0.04) * random.direction(),
                    about(random.direction(), random.uniform(-3, 3))};
    PartPairs near;
    update_part_pairs(body, objects, pose, true, near);
    const ShellContact at = polygon_contact(body, objects, kFace, near, pose);
    if (!(at.energy > 1e-6)) continue;
    ++touching;
    Vec6 differences;
    for (int k = 0; k < 6; ++k) {
      Vec6 by = Vec6::Zero();
      by[k] = k < 3 ? 1e-7 : 1e-5;
      const auto energy = [&](const Vec6& way) {
        return polygon_contact(body, objects, kFace, near,
                               moved(pose, way.head<3>(), way.tail<3>()))
            .energy;
      };
      differences[k] = (energy(by) - energy(-by)) / (2.0 * by[k]);
    }
    Vec6 wrench = at.wrench;
    wrench.tail<3>() /= 0.03;
    differences.tail<3>() /= 0.03;
    EXPECT_LT((wrench + differences).norm(), 1e-4 * wrench.norm()) << i;
    Vec6 parts = Vec6::Zero();
    for (const ObjectWrench& part : at.touched()) parts += part.wrench;
    EXPECT_LT((parts - at.wrench).norm(), 1e-12 * at.wrench.norm());
  }
  EXPECT_GT(touching, 30);
}

/// Returns a plate of 20 mm with a square hole, made of four bars.
SolidParts plate_with_hole(double half_hole) {
  const double outer = 0.04, half_bar = 0.5 * (outer - half_hole), at = half_hole + half_bar;
  return solid_parts({box_corners(Vec3(half_bar, outer, 0.01), Vec3(at, 0, -0.01)),
                      box_corners(Vec3(half_bar, outer, 0.01), Vec3(-at, 0, -0.01)),
                      box_corners(Vec3(half_hole, half_bar, 0.01), Vec3(0, at, -0.01)),
                      box_corners(Vec3(half_hole, half_bar, 0.01), Vec3(0, -at, -0.01))});
}

/// Stores the largest change of the force in a single step.
struct Jumps {
  Vec3 last = Vec3::Zero();
  double largest = 0.0;
  void add(const Vec3& force) {
    largest = std::max(largest, (force - last).norm());
    last = force;
  }
};

TEST(PolygonBody, APegWithATenthOfAMillimetreOfPlayGoesIn) {
  // The peg is 20 mm square and 40 mm long. The hole is 0.1 mm wider, but the hand moves and tilts
  // by more.
  const BodyTool body = tool({box_corners(Vec3(0.01, 0.01, 0.02))}, {plate_with_hole(0.01005)});
  const std::vector<Object> objects = {object()};
  BodyMemory memory;
  Jumps jumps;
  Pose device{Vec3(0, 0, 0.021), kUpright};
  for (int i = 0; i < 1000; ++i) {
    const double time = 1e-3 * i, deep = std::max(0.0, time - 0.02);
    const double sway = std::min(1.0, 5.0 * deep) * 1e-3;
    device.position = Vec3(3e-5 + sway * std::sin(12.0 * time), sway * std::cos(9.0 * time) - sway,
                           0.021 - 0.02 * time);
    device.orientation = about(Vec3(1, 2, 0).normalized(), 20.0 * sway * std::sin(7.0 * time));
    jumps.add(step(body, objects, device, memory).command.force());
  }
  // The peg is in the hole, nearly as far as the hand.
  EXPECT_LT(memory.pose.position.z(), 0.0025);
  EXPECT_LT(std::abs(memory.pose.position.x()), 1e-3);
  EXPECT_LT(jumps.largest, 0.2);
  EXPECT_GT(jumps.last.norm(), 0.05);  // The peg still touches.
}

TEST(PolygonBody, TheCornerOfABoxGoesOverASharpEdgeWithoutAJump) {
  // A hand presses a lower edge of the tool down with about 2 N. The tool slides off the table
  // across its edge.
  const BodyTool body = tool({box_corners(kHalf)}, {box(Vec3(0.05, 0.05, 0.02))});
  const std::vector<Object> objects = {object()};
  for (const double tilt : {0.0, 0.3}) {
    const double reach = 0.03 * std::sin(tilt) + 0.01 * std::cos(tilt);
    BodyMemory memory;
    Jumps jumps;
    double most = 0.0;
    for (int i = 0; i < 3000; ++i) {
      const double down = std::min(4e-3, 1e-5 * i);
      const Pose device{Vec3(5e-5 * std::max(0, i - 500), 0.003, 0.02 + reach - down),
                        about(Vec3::UnitY(), tilt)};
      const Vec3 force = step(body, objects, device, memory).command.force();
      jumps.add(force);
      most = std::max(most, force.norm());
    }
    EXPECT_GT(most, 0.5) << tilt;
    EXPECT_LT(jumps.last.norm(), 1e-3) << tilt;  // The tool is off the table.
    EXPECT_LT(jumps.largest, 0.2) << tilt;
  }
}

// A hand moves through a wall of 0.2 mm at 1 m/s or in one step. A face, an edge or a corner is in
// front, from both sides and near the rim.
TEST(PolygonBody, AFastHandDoesNotPassAThinWall) {
  const Corners spike = {Vec3(0, 0, -0.02), Vec3(0.008, 0, 0.01), Vec3(-0.004, 0.007, 0.01),
                         Vec3(-0.004, -0.007, 0.01)};
  for (const Corners& part : {box_corners(Vec3::Constant(0.01)), spike}) {
    const BodyTool body = tool({part}, {box(Vec3(0.05, 0.05, 1e-4))}, {.max_force = 10.0}, 1e-4);
    const std::vector<Object> objects = {object()};
    for (const double stride : {1e-3, 0.02, 0.12})
      for (const Quaternion& turned :
           {kUpright, about(Vec3::UnitX(), 0.7), about(Vec3(1, 2, 0).normalized(), 0.9)})
        for (const double side : {1.0, -1.0}) {
          BodyMemory memory;
          const Quaternion from =
              side > 0.0 ? turned : Quaternion(about(Vec3::UnitX(), std::numbers::pi) * turned);
          BodyStep now;
          double height = 0.05;
          for (; height > -0.07; height -= stride)
            now = step(body, objects, {Vec3(0.003, 0.002, side * height), from}, memory);
          for (int i = 0; i < 100; ++i)
            now = step(body, objects, {Vec3(0.003, 0.002, -side * 0.07), from}, memory);
          EXPECT_GT(side * now.command.force().z(), 9.9) << stride;
          EXPECT_GT(side * memory.pose.position.z(), -0.02) << stride;
          // After a movement back out, no force must remain.
          for (int i = 0; i < 300; ++i)
            now = step(body, objects, {Vec3(0.003, 0.002, side * (2e-4 * i)), from}, memory);
          EXPECT_LT(now.command.force().norm(), 1e-3) << stride;
        }
  }
}

// The tool slides along the wall under load, passes the end of the wall and moves down next to the
// wall. The force must end there.
TEST(PolygonBody, BesideAThinWallThereIsNothing) {
  const BodyTool body =
      tool({box_corners(Vec3::Constant(0.005))}, {box(Vec3(0.02, 0.02, 1e-4))}, {}, 1e-4);
  const std::vector<Object> objects = {object()};
  BodyMemory memory;
  BodyStep now;
  for (int i = 0; i < 100; ++i)
    now = step(body, objects, {Vec3(2e-5 * i, 0, 0.01 - 8e-5 * i), kUpright}, memory);
  EXPECT_GT(now.command.force().z(), 1.0);
  for (int i = 0; i < 600; ++i)
    now = step(body, objects, {Vec3(2e-3 + 5e-5 * i, 0, 2e-3), kUpright}, memory);
  EXPECT_LT(now.command.force().norm(), 1e-3);
  for (int i = 0; i < 400; ++i)
    now = step(body, objects, {Vec3(0.032, 0, 2e-3 - 1e-4 * i), kUpright}, memory);
  EXPECT_LT(now.command.force().norm(), 1e-3);
  // The tool moves below the wall, and up against its other side.
  for (int i = 0; i < 400; ++i)
    now = step(body, objects, {Vec3(0.032 - 1e-4 * i, 0, -0.038), kUpright}, memory);
  EXPECT_LT(now.command.force().norm(), 1e-3);
  for (int i = 0; i < 400; ++i)
    now = step(body, objects, {Vec3(-8e-3, 0, -0.038 + 1e-4 * i), kUpright}, memory);
  EXPECT_LT(now.command.force().z(), -1.0);
}

// After an oblique approach, the depth of a pair of convex parts is measured in an oblique
// direction. If the energy stays equal, the direction must turn to the force's direction.
TEST(PolygonBody, TheDirectionOfAPairFollowsTheForce) {
  const PolygonBody body =
      polygon_body({box_corners(Vec3::Constant(0.005))}, {box(Vec3(0.05, 0.05, 1e-3))});
  const std::vector<Object> objects = {object()};
  const Vec3 aslant = Vec3(0.5, 0.0, 1.0).normalized();
  for (const bool beyond : {false, true}) {
    // The tool is in the middle of the wall, or at its end, where an oblique thickening widens the
    // wall.
    const Pose pose{Vec3(beyond ? -0.0525 : 0.0, 0, 6e-3 - 1e-4), kUpright};
    PartPairs near;
    update_part_pairs(body, objects, pose, true, near);
    ASSERT_EQ(near.count, 1u);
    near.pairs[0].thickened = true;
    near.pairs[0].away = aslant;
    const double before = polygon_contact(body, objects, kFace, near, pose).energy;
    for (int i = 0; i < 3; ++i) update_part_pairs(body, objects, pose, false, near);
    const double after = polygon_contact(body, objects, kFace, near, pose).energy;
    ASSERT_GT(before, 0.0);
    EXPECT_NEAR(after, before, 1e-9 * before);
    EXPECT_EQ(near.pairs[0].away.z() > 0.999, !beyond);
  }
}

TEST(PolygonBody, FrictionHoldsUpToItsCone) {
  const BodyTool body = tool({box_corners(kHalf)}, {box(Vec3(0.1, 0.1, 0.05))});
  std::vector<Object> objects = {object()};
  objects[0].material.static_friction = objects[0].material.dynamic_friction = 0.5;
  BodyMemory memory;
  BodyStep now;
  for (int i = 0; i < 100; ++i)
    now = step(body, objects, {Vec3(0, 0, 0.061 - 5e-5 * i), kUpright}, memory);
  const double load = now.command.force().z();
  ASSERT_GT(load, 1.0);
  const double holds = 0.4 * load / 1000.0;
  for (int i = 0; i < 20; ++i)
    now = step(body, objects, {Vec3(holds, 0, 0.061 - 5e-5 * 99), kUpright}, memory);
  // The hand pulls above the table and tilts the tool slightly. The face must stay in place.
  const Vec3 sole = memory.pose.position + memory.pose.orientation * Vec3(0, 0, -0.01);
  EXPECT_LT(std::abs(sole.x()), 0.02 * holds);
  EXPECT_NEAR(now.command.force().x(), -0.4 * load, 0.02 * load);
  for (int i = 0; i < 200; ++i)
    now = step(body, objects, {Vec3(5e-5 * i, 0, 0.061 - 5e-5 * 99), kUpright}, memory);
  EXPECT_NEAR(now.command.force().x(), -0.5 * now.command.force().z(), 0.02 * load);
}

// The memory of the previous step only saves time. The result must not depend on this memory.
TEST(PolygonBody, WhatItRemembersOfAPairChangesNothing) {
  const BodyTool body =
      tool({box_corners(kHalf), box_corners(Vec3(0.004, 0.004, 0.02))},
           {solid_parts({box_corners(Vec3(0.02, 0.02, 0.005)),
                         box_corners(Vec3(0.005, 0.02, 0.01), Vec3(0.015, 0, 0.015))})});
  const std::vector<Object> objects = {object()};
  BodyMemory kept, forgetful;
  test::Random random(12);
  Pose device{Vec3(0, 0, 0.04), kUpright};
  std::size_t used = 0, shared = 0;
  for (int i = 0; i < 1500; ++i) {
    const Pose before = device;
    device = moved(device, random.vector(-5.0, -2.7), random.vector(-4.0, -1.5));
    if (device.position.norm() > 0.04) device = before;
    const BodyStep one = step(body, objects, device, kept);
    forgetful.near.push.known = false;
    for (PartPair& pair : forgetful.near.pairs) pair.overlaps = false;
    const BodyStep two = step(body, objects, device, forgetful);
    ASSERT_LE((one.command.force() - two.command.force()).norm(), 1e-6) << i;
    ASSERT_LE((one.command.torque - two.command.torque).norm(), 1e-8) << i;
    used += kept.near.push.known ? 1 : 0;
    for (std::size_t p = 0; p < kept.near.count; ++p) shared += kept.near.pairs[p].overlaps ? 1 : 0;
  }
  EXPECT_GT(used, 300u);
  EXPECT_GT(shared, 300u);
}

TEST(PolygonBody, IsTheSameTwiceAndAllocatesNothing) {
  const BodyTool body = tool({box_corners(kHalf), box_corners(Vec3(0.004, 0.004, 0.02))},
                             {plate_with_hole(0.0043), solid_parts(Plane{}, Side::outside),
                              solid_parts(Cylinder{0.05, 0.08}, Side::inside)});
  const std::vector<Object> objects = {object(), object(Vec3(0, 0, -0.03)), object()};
  test::same_twice_without_allocation([&] {
    BodyMemory memory;
    test::Random random(11);
    Pose device{Vec3(0, 0, 0.03), kUpright};
    Vec6 sum = Vec6::Zero();
    std::size_t touching = 0;
    for (int i = 0; i < 1500; ++i) {
      const Pose before = device;
      device = moved(device, random.vector(-5.0, -2.5), random.vector(-4.0, -1.5));
      if (device.position.norm() > 0.05) device = before;
      const BodyStep now = step(body, objects, device, memory);
      sum.head<3>() += now.command.force();
      sum.tail<3>() += now.command.torque;
      touching += now.touching;
    }
    EXPECT_GT(touching, 1000u);
    return sum;
  });
}

}  // namespace
}  // namespace feltwire::polygon_body_test
