#include "core/mesh/mesh_contact.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/contact/contact.hpp"
#include "core/scene/scene.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/meshes.hpp"

namespace feltwire::mesh_contact_test {
namespace {

using test::mesh_object;

Object shape_object(const Shape& shape, Side side = Side::outside) {
  Object o;
  o.name = "shape";
  o.shape = shape;
  o.felt_from = side;
  return o;
}

/// Returns the force at the end of a path, in steps of at most `step` [m].
Command follow(const Object& object, const std::vector<Vec3>& way, ContactMemory& memory,
               double step = 1e-3) {
  Command last;
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    const Vec3 leg = way[i + 1] - way[i];
    const int steps = std::max(1, static_cast<int>(std::ceil(leg.norm() / step)));
    for (int n = i == 0 ? 0 : 1; n <= steps; ++n)
      last = touch(object, {way[i] + leg * n / steps, Vec3::Zero()}, memory);
  }
  return last;
}

TEST(MeshContact, ASphereOfFacetsIsASphereWithinTheFacets) {
  constexpr double kRadius = 0.09, kDepth = 0.002, kStiffness = 5000.0;
  for (const int level : {3, 5}) {
    const Object ball = mesh_object(test::icosphere(kRadius, level), {}, {.stiffness = kStiffness});
    // [rad], [m] largest deviation of an icosphere's facets from the tangent plane
    const double corner = 0.77 / std::pow(2.0, level);
    const double sagitta = kRadius * (1.0 - std::cos(corner));
    ContactMemory memory;
    double worst = 0.0;
    for (int n = 0; n < 4000; ++n) {
      const double t = 1e-3 * n, turn = 0.1 / kRadius * t;
      const double depth = std::min(kDepth, 0.05 * t - 0.001);
      const Vec3 out(std::cos(turn) * std::cos(0.7 * turn), std::sin(turn) * std::cos(0.7 * turn),
                     std::sin(0.7 * turn));
      const Command c = touch(ball, {(kRadius - depth) * out, Vec3::Zero()}, memory);
      if (depth < 0.0) {
        EXPECT_EQ(c.elastic, Vec3::Zero());
        continue;
      }
      if (depth < kDepth) continue;
      EXPECT_NEAR(c.elastic.norm(), kStiffness * kDepth, kStiffness * sagitta * 1.1) << n;
      worst = std::max(worst, test::angle(c.elastic, out));
    }
    EXPECT_LT(worst, corner);
    EXPECT_GT(worst, 0.3 * corner);
  }
}

TEST(MeshContact, ABoxOfTrianglesIsTheBox) {
  const Vec3 half(0.05, 0.04, 0.03);
  for (const int n : {1, 7})
    for (const Side side : {Side::outside, Side::inside}) {
      const Object mesh = mesh_object(test::box(half, n), {}, {}, side);
      const Object box = shape_object(Box{half}, side);
      test::Random random(3);
      for (int run = 0; run < 40; ++run) {
        ContactMemory of_mesh, of_box;
        Vec3 p = side == Side::outside ? Vec3(0.1 * random.direction())
                                       : Vec3(0.01 * random.direction());
        Vec3 v = Vec3::Zero();
        int touched = 0;
        for (int i = 0; i < 400; ++i) {
          v = 0.9 * v + 3e-4 * random.direction() - (side == Side::outside ? 0.002 : -0.002) * p;
          p += v;
          const bool inside = (p.cwiseAbs() - half).maxCoeff() < 0.0;
          const Command a = touch(mesh, {p, Vec3::Zero()}, of_mesh);
          const Command b = touch(box, {p, Vec3::Zero()}, of_box);
          // At entry the box uses the nearest face, but the mesh uses the face that the tool
          // crossed. The mesh also holds a tool that passed through the complete box.
          if (side == Side::outside && (a.elastic - b.elastic).norm() > 1e-6) {
            ASSERT_TRUE(inside || of_mesh.touching);
            ASSERT_GT(a.elastic.norm(), 0.0);
            ASSERT_NEAR(a.elastic.cwiseAbs().maxCoeff(), a.elastic.norm(), 1e-6);
            break;
          }
          ASSERT_NEAR((a.elastic - b.elastic).norm(), 0.0, 1e-7)
              << run << " " << i << " " << p.transpose() << " mesh " << a.elastic.transpose()
              << " box " << b.elastic.transpose();
          touched += b.elastic.norm() > 0.0;
        }
        if (side == Side::inside) {
          EXPECT_GT(touched, 50);
        }
      }
    }
}

TEST(MeshContact, ATorusIsATorusWithinTheFacets) {
  constexpr double kRing = 0.06, kTube = 0.02, kDepth = 0.003;
  const Object torus = mesh_object(test::torus(kRing, kTube, 256, 128), {}, {.stiffness = 1000.0});
  ContactMemory memory;
  for (int n = 0; n < 6000; ++n) {
    const double u = 2.0 * M_PI * n / 2000.0, v = 2.0 * M_PI * n / 1500.0;
    const double depth = std::min(kDepth, 1e-5 * n - 0.001);
    const double r = kRing + (kTube - depth) * std::cos(v);
    const Vec3 out(std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v));
    const Command c =
        touch(torus,
              {Vec3(r * std::cos(u), r * std::sin(u), (kTube - depth) * std::sin(v)), Vec3::Zero()},
              memory);
    if (depth < kDepth) continue;
    ASSERT_NEAR(c.elastic.norm(), 3.0, 0.02) << n;
    ASSERT_LT(test::angle(c.elastic, out), 0.035) << n;
  }
}

// A path leads through the edge of a box, from the top to the side. At both ends the force must be
// the force of a face.
TEST(MeshContact, SharpEdgesGiveTheFacesForceAndNoOther) {
  const Object box = mesh_object(test::box(Vec3(0.05, 0.05, 0.05), 3));
  ContactMemory memory;
  const Vec3 on_top =
      follow(box, {{0.04, 0.003, 0.06}, {0.04, 0.003, 0.045}}, memory, 1e-4).elastic;
  EXPECT_NEAR((on_top - Vec3(0, 0, 5)).norm(), 0.0, 1e-9);
  // The tool did not leave the top. The top must hold the tool even where the side is nearer.
  EXPECT_NEAR((follow(box, {{0.04, 0.003, 0.045}, {0.049, 0.003, 0.045}}, memory, 1e-4).elastic -
               Vec3(0, 0, 5))
                  .norm(),
              0.0, 1e-9);
  // The tool leaves through the side, and no force must act. When the tool returns, the side must
  // hold it.
  EXPECT_EQ(follow(box, {{0.049, 0.003, 0.045}, {0.052, 0.003, 0.045}}, memory, 1e-4).elastic,
            Vec3::Zero());
  EXPECT_NEAR((follow(box, {{0.052, 0.003, 0.045}, {0.047, 0.003, 0.045}}, memory, 1e-4).elastic -
               Vec3(3, 0, 0))
                  .norm(),
              0.0, 1e-9);
}

TEST(MeshContact, NoSpeedPassesASheet) {
  for (const int cells : {1, 16, 64})
    for (const double radius : {0.0, 0.001}) {
      const Object sheet = mesh_object(
          test::sheet(0.1, cells), {.double_sided = true, .radius = radius}, {.stiffness = 1000.0});
      test::Random random(5);
      for (int run = 0; run < 60; ++run) {
        const double from = run % 2 == 0 ? 1.0 : -1.0;
        const Vec3 way =
            Vec3(random.uniform(-1, 1), random.uniform(-1, 1), -from * 1.0).normalized();
        Vec3 p(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02),
               from * random.uniform(0.004, 0.02));
        ContactMemory memory;
        touch(sheet, {p, Vec3::Zero()}, memory);
        double depth = 0.0;
        for (int n = 0; n < 4; ++n) {  // a speed of 10 m/s
          p += 0.01 * way;
          depth = radius - from * p.z();
          const Command c = touch(sheet, {p, Vec3::Zero()}, memory);
          const Vec3 expected(0.0, 0.0, from * 1000.0 * std::max(0.0, depth));
          ASSERT_NEAR((c.elastic - expected).norm(), 0.0, 1e-3) << cells << " " << run << " " << n;
        }
        // The tool moves around the edge of the sheet. No force must then act.
        EXPECT_GT(depth, 0.0);
        follow(sheet, {p, Vec3(0.2, p.y(), p.z()), Vec3(0.2, p.y(), -from * 0.05)}, memory);
        EXPECT_EQ(touch(sheet, {Vec3(0.2, p.y(), -from * 0.05), Vec3::Zero()}, memory).elastic,
                  Vec3::Zero());
      }
    }
}

TEST(MeshContact, ATenthOfAMillimetreAndAHundredMetresInOneMesh) {
  TriangleSoup soup;
  soup.vertices = {{0, 0, 0},     {100, 0, 0},        {0, 100, 0},
                   {10, 10, 0.5}, {10.0001, 10, 0.5}, {10, 10.0001, 0.5}};
  soup.triangles = {{0, 1, 2}, {3, 4, 5}};
  const Object mesh = mesh_object(soup);
  ContactMemory memory;
  const Vec3 small(10.00003, 10.00003, 0.5);
  touch(mesh, {small + Vec3(0, 0, 0.002), Vec3::Zero()}, memory);
  EXPECT_NEAR(touch(mesh, {small - Vec3(0, 0, 0.002), Vec3::Zero()}, memory).elastic.z(), 2.0,
              1e-9);
  memory = {};
  touch(mesh, {Vec3(30, 30, 0.002), Vec3::Zero()}, memory);
  EXPECT_NEAR(touch(mesh, {Vec3(30, 30, -0.002), Vec3::Zero()}, memory).elastic.z(), 2.0, 1e-9);
}

// The force must depend neither on the position nor on the size of the mesh.
TEST(MeshContact, PlaceAndScaleChangeNothing) {
  const TriangleSoup bumpy = [] {
    TriangleSoup s = test::icosphere(1.0, 3);
    test::Random random(9);
    for (Vec3& v : s.vertices) v *= random.uniform(0.85, 1.0);
    return s;
  }();
  const auto forces = [&](double scale, const Vec3& by, double radius) {
    const Object mesh =
        mesh_object(test::moved(bumpy, by, scale), {.radius = radius * scale}, {.stiffness = 1.0});
    ContactMemory memory;
    std::vector<Vec3> out;
    for (int n = 0; n < 1500; ++n) {
      const double t = 0.01 * n;
      const Vec3 p =
          (1.05 - 0.2 * std::min(1.0, t)) *
          Vec3(std::cos(t), std::sin(t) * std::cos(0.3 * t), std::sin(t) * std::sin(0.3 * t));
      out.push_back(touch(mesh, {scale * p + by, Vec3::Zero()}, memory).elastic / scale);
    }
    return out;
  };
  for (const double radius : {0.0, 0.05}) {
    const auto expected = forces(1.0, Vec3::Zero(), radius);
    EXPECT_GT(expected.back().norm(), 0.02);
    const std::array<std::pair<double, Vec3>, 3> others = {
        {{1e-6, Vec3::Zero()}, {0x1p18, Vec3::Zero()}, {1.0, Vec3(0x1p20, -0x1p20, 0x1p19)}}};
    for (const auto& [scale, by] : others) {
      const auto found = forces(scale, by, radius);
      // Far away the tool's own position has fewer digits.
      const double tolerance = 1e-5;
      std::size_t differing = 0;
      for (std::size_t i = 0; i < found.size(); ++i)
        differing += (found[i] - expected[i]).norm() > tolerance;
      EXPECT_LT(differing, found.size() / 100) << scale << " " << radius;
    }
  }
}

TEST(MeshContact, WhoBeginsInsideIsPushedOutByTheNearest) {
  const Object ball = mesh_object(test::icosphere(0.1, 4), {}, {.stiffness = 1000.0});
  ContactMemory memory;
  const Command c = touch(ball, {Vec3(0.0, 0.06, 0.07), Vec3::Zero()}, memory);
  EXPECT_NEAR(c.elastic.norm(), 1000.0 * (0.1 - std::hypot(0.06, 0.07)), 0.3);
  EXPECT_LT(test::angle(c.elastic, Vec3(0.0, 0.06, 0.07)), 0.05);
  memory = {};
  EXPECT_EQ(touch(ball, {Vec3(0.0, 0.08, 0.07), Vec3::Zero()}, memory).elastic, Vec3::Zero());
}

TEST(MeshContact, AnotherPartOfTheMeshThatPassesThroughHoldsTheHandToo) {
  // Two plates cross without a common corner and form a valley.
  TriangleSoup cross = test::sheet(0.1, 5);
  TriangleSoup wall = test::sheet(0.1, 3);
  for (Vec3& v : wall.vertices) v = Vec3(0.031, v.y(), v.x());
  for (Triangle& t : wall.triangles) std::swap(t[0], t[1]);  // The wall faces -x.
  const Object mesh =
      mesh_object(test::joined(cross, wall), {.double_sided = true}, {.stiffness = 1000.0});
  ContactMemory memory;
  const Command c =
      follow(mesh, {{-0.05, 0.0, 0.01}, {-0.05, 0.0, -0.002}, {0.036, 0.01, -0.003}}, memory, 1e-3);
  EXPECT_NEAR((c.elastic - Vec3(-5.0, 0.0, 3.0)).norm(), 0.0, 1e-3) << c.elastic.transpose();
  // The path leads back.
  const Command d = follow(mesh, {{0.036, 0.01, -0.003}, {-0.02, 0.01, -0.003}}, memory, 1e-3);
  EXPECT_NEAR((d.elastic - Vec3(0.0, 0.0, 3.0)).norm(), 0.0, 1e-3) << d.elastic.transpose();
}

TEST(MeshContact, FrictionKeepsItsConeOnEveryTessellation) {
  for (const int level : {2, 4, 6}) {
    const Material rough{.stiffness = 1000.0, .static_friction = 0.5, .dynamic_friction = 0.4};
    const Object ball = mesh_object(test::icosphere(0.05, level), {}, rough);
    ContactMemory memory;
    int slid = 0;
    for (int n = 0; n < 3000; ++n) {
      const double t = 1e-3 * n;
      const double depth = std::min(0.003, 0.02 * t - 0.001);
      const Vec3 out(std::cos(t), std::sin(t), 0.0);
      const Command c = touch(ball, {(0.05 - depth) * out, Vec3::Zero()}, memory);
      ASSERT_LE(c.frictional.norm(), 0.5 * c.elastic.norm() * (1.0 + 1e-9) + 1e-12);
      if (!memory.touching) continue;
      ASSERT_NEAR(c.frictional.dot(c.elastic), 0.0, 1e-9 * c.elastic.squaredNorm());
      if (n > 1000 && memory.slipping) {
        ++slid;
        ASSERT_NEAR(c.frictional.norm(), 0.4 * c.elastic.norm(), 1e-9);
        ASSERT_GT(c.frictional.dot(-Vec3(-std::sin(t), std::cos(t), 0.0)),
                  0.7 * c.frictional.norm());
      }
    }
    EXPECT_GT(slid, level == 2 ? 1000 : 1900) << level;
  }
}

// On a closed path the elastic force must give no energy. At each edge the hand loses energy in
// proportion to the square of the edge's angle. The number of edges is inverse to the angle, so the
// total loss is proportional to the angle. A smooth sphere has no loss.
TEST(MeshContact, AClosedWayNeverGivesAndTakesLessTheFinerTheFacets) {
  double coarser = 0.0;
  for (const int level : {3, 4, 5}) {
    const Object ball = mesh_object(test::icosphere(0.05, level), {}, {.stiffness = 1000.0});
    ContactMemory memory;
    constexpr int kSteps = 20000;
    double work = 0.0, moved = 0.0;  // [J] work on the hand
    Vec3 last = Vec3::Zero(), force = Vec3::Zero();
    for (int n = 0; n <= kSteps + 1; ++n) {
      const double t = 2.0 * M_PI * n / kSteps;
      const Vec3 p = (0.05 - 0.0012 + 0.0018 * std::cos(3.0 * t)) *
                     Vec3(std::cos(t), std::sin(t) * 0.8, std::sin(t) * 0.6);
      const Vec3 now = touch(ball, {p, Vec3::Zero()}, memory).elastic;
      if (n > 1) {
        const double part = 0.5 * (now + force).dot(p - last);
        work += part;
        moved += std::abs(part);
      }
      last = p;
      force = now;
    }
    EXPECT_LT(work, 1e-4 * moved) << level;
    EXPECT_GT(work, -0.08 * std::pow(0.5, level - 3) * moved) << level;
    EXPECT_TRUE(level == 3 || work > 0.75 * coarser) << level;
    coarser = work;
    RecordProperty("work_" + std::to_string(level), std::to_string(work / moved));
  }
}

TEST(MeshContact, WhatIsNotFiniteIsRefusedAndContactKept) {
  const Scene scene("s", {mesh_object(test::icosphere(0.09, 3), {}, {.stiffness = 5000.0})});
  TouchMemory memory = scene.memory();
  scene.touch({Vec3(0, 0, 0.1), Vec3::Zero()}, memory);
  const Command before = scene.touch({Vec3(0.001, 0, 0.088), Vec3::Zero()}, memory);
  EXPECT_GT(before.elastic.z(), 5.0);
  EXPECT_EQ(scene.touch({Vec3(0, std::nan(""), 0.088), Vec3::Zero()}, memory), Command{});
  EXPECT_EQ(scene.touch({Vec3(0.001, 0, 0.088), Vec3::Zero()}, memory), before);
}

TEST(MeshContact, TouchNeverAllocates) {
  for (const double radius : {0.0, 0.002}) {
    const Object ball = mesh_object(test::icosphere(0.05, 4), {.smooth = true, .radius = radius},
                                    {.static_friction = 0.5, .dynamic_friction = 0.4});
    ContactMemory memory;
    const std::size_t before = test::allocations();
    for (int n = 0; n < 3000; ++n)
      touch(
          ball,
          {(0.05 + 0.004 * std::sin(0.01 * n)) * Vec3(std::cos(0.02 * n), std::sin(0.02 * n), 0.0),
           Vec3::Zero()},
          memory);
    EXPECT_EQ(test::allocations(), before);
  }
}

TEST(MeshContact, ABallFeelsTheOffsetSurface) {
  constexpr double kRadius = 0.01;
  const Vec3 half(0.05, 0.05, 0.05);
  const Object box = mesh_object(test::box(half, 4), {.radius = kRadius}, {.stiffness = 1000.0});
  ContactMemory memory;
  // The ball presses on a face.
  EXPECT_NEAR(
      (follow(box, {{0.02, 0.01, 0.07}, {0.02, 0.01, 0.058}}, memory).elastic - Vec3(0, 0, 2))
          .norm(),
      0.0, 1e-4);
  // At an edge, the force must equal the force of a cylinder.
  const double a = 0.6, d = 0.003;
  const Vec3 out(std::cos(a), 0.0, std::sin(a));
  memory = {};
  const Vec3 edge(0.05, 0.01, 0.05);
  EXPECT_NEAR(
      (follow(box, {edge + 0.02 * out, edge + (kRadius - d) * out}, memory).elastic - 3.0 * out)
          .norm(),
      0.0, 1e-4);
  // At a corner, the force must equal the force of a ball.
  const Vec3 corner_out = Vec3(1.0, 2.0, 1.5).normalized();
  memory = {};
  EXPECT_NEAR(
      (follow(box, {half + 0.02 * corner_out, half + (kRadius - d) * corner_out}, memory).elastic -
       3.0 * corner_out)
          .norm(),
      0.0, 1e-4);
  // From inside, the ball touches three faces in a corner at once.
  const Object room =
      mesh_object(test::box(half, 4), {.radius = kRadius}, {.stiffness = 1000.0}, Side::inside);
  memory = {};
  EXPECT_NEAR(
      (follow(room, {Vec3::Zero(), Vec3(0.042, 0.044, 0.047)}, memory).elastic - Vec3(-2, -4, -7))
          .norm(),
      0.0, 1e-3);
}

TEST(MeshContact, ABallOnASphereOfFacets) {
  constexpr double kTool = 0.001, kRadius = 0.09, kDepth = 0.002;
  const Object ball =
      mesh_object(test::icosphere(kRadius, 5), {.radius = kTool}, {.stiffness = 5000.0});
  ContactMemory memory;
  for (int n = 0; n < 3000; ++n) {
    const double turn = 0.1 / kRadius * 1e-3 * n, depth = std::min(kDepth, 2e-5 * n - 0.001);
    const Vec3 out(std::cos(turn) * std::cos(0.7 * turn), std::sin(turn) * std::cos(0.7 * turn),
                   std::sin(0.7 * turn));
    const Command c = touch(ball, {(kRadius + kTool - depth) * out, Vec3::Zero()}, memory);
    if (depth < kDepth) continue;
    ASSERT_NEAR(c.elastic.norm(), 10.0, 0.2) << n;
    ASSERT_LT(test::angle(c.elastic, out), 0.77 / 32.0) << n;
  }
}

}  // namespace
}  // namespace feltwire::mesh_contact_test
