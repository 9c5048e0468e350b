// A client stops contact with fetched geometry that takes too much work. A stopped tick must have
// no effect for any geometry.

#include "core/base/work_limit.hpp"

#include <gtest/gtest.h>

#include "core/local_model/contact_budget.hpp"
#include "core/local_model/local_body.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/prefetched_geometry/contact_trial.hpp"
#include "core/prefetched_geometry/make_prefetched_tool.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"
#include "core/tool_coupling/descent.hpp"
#include "tests/core/heavy_geometry.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::work_limit_test {
namespace {

constexpr std::uint32_t kVersion = 7;
constexpr double kTick = 1e-3;  // [s]
const std::uint64_t kMost = units_within(contact_budget(kTick));
constexpr Material kMaterial{.stiffness = 1000.0, .static_friction = 0.5, .dynamic_friction = 0.4};

TEST(WorkLimit, TakesUpToItsLimitAndNothingAfterwards) {
  WorkLimit work(10);
  EXPECT_TRUE(work.take(7));
  EXPECT_TRUE(work.take(3));
  EXPECT_FALSE(work.cut());
  EXPECT_FALSE(work.take(1));
  EXPECT_TRUE(work.cut());
  WorkLimit more(10);
  EXPECT_FALSE(more.take(11));
  EXPECT_FALSE(more.take(1));
  EXPECT_EQ(more.done(), 10u);
  EXPECT_TRUE(may_go_on(nullptr, WorkLimit::kUnlimited));
  EXPECT_FALSE(is_cut(nullptr));
}

SurfaceData with_radius(SurfaceData data, double radius) {
  data.radius = radius;
  return data;
}

SurfaceData ring() {
  SurfaceData data;
  const TriangleSoup soup = tessellate(Torus{0.05, 0.02}, 24);
  data.vertices = soup.vertices;
  data.triangles = soup.triangles;
  return data;
}

bool same(const ContactMemory& a, const ContactMemory& b) {
  return a.touching == b.touching && a.slipping == b.slipping && a.anchor == b.anchor &&
         a.feature.feature == b.feature.feature && a.feature.normal == b.feature.normal &&
         a.feature.proxy == b.feature.proxy && a.feature.triangle == b.feature.triangle &&
         a.feature.side == b.feature.side && a.feature.tracked == b.feature.tracked;
}

/// A touch with a limit must equal the unlimited touch bitwise, or leave the memory unchanged. If a
/// limit is sufficient for a touch, it must be sufficient for an equal touch.
TEST(WorkLimit, ATouchIsWholeOrLeavesNothing) {
  for (const double radius : {0.0, 5e-3}) {
    const auto surfaces = mesh_surfaces(kVersion, {with_radius(ring(), radius)});
    ContactMemory memory;
    std::uint64_t most = 0;
    for (int n = 0; n < 60; ++n) {
      const double turn = 0.05 * n, depth = 0.002 * std::sin(0.4 * n);
      const Tool tool{(0.05 + (0.02 + radius - depth) * std::cos(turn)) * Vec3::UnitX() +
                          (0.02 + radius - depth) * std::sin(turn) * Vec3::UnitZ() +
                          0.001 * n * Vec3::UnitY(),
                      Vec3(0.1, 0.2, 0.3)};
      ContactMemory whole = memory;
      WorkLimit unlimited(WorkLimit::kUnlimited);
      const Command felt = surfaces->touch(0, kMaterial, tool, whole, &unlimited);
      const std::uint64_t needed = unlimited.done();
      most = std::max(most, needed);
      for (std::uint64_t limit = 0; limit <= needed; ++limit) {
        ContactMemory after = memory;
        WorkLimit work(limit);
        const Command command = surfaces->touch(0, kMaterial, tool, after, &work);
        ASSERT_EQ(work.cut(), limit < needed) << limit << " of " << needed;
        ASSERT_TRUE(same(after, work.cut() ? memory : whole)) << limit;
        ASSERT_TRUE(work.cut() || command == felt);
      }
      memory = whole;
    }
    EXPECT_LT(most, kMost) << radius;
    EXPECT_GT(most, 10u) << radius;
  }
}

bool same(const BodyMemory& a, const BodyMemory& b) {
  return a.pose.position == b.pose.position &&
         a.pose.orientation.coeffs() == b.pose.orientation.coeffs() && a.slipping == b.slipping &&
         a.known == b.known && a.velocity.linear == b.velocity.linear &&
         a.velocity.angular == b.velocity.angular && a.device_known == b.device_known;
}

/// Returns the energy [J] of a massless tool at rest at `tool`.
double energy_at(const PrefetchedTool& body, const Pose& device, const Pose& tool) {
  return tool_coupling::pull(body.coupling, device, tool).energy +
         body.solids->contact(tool).energy;
}

/// A limited step of a body must have no effect, or lead to a position without more energy. A
/// sufficient limit must give the unlimited step bitwise.
TEST(WorkLimit, AStepOfABodyGoesAsFarAsItsWorkLasts) {
  for (const double mass : {0.0, 0.1}) {
    BodyData data = test::ball_of_points(300);
    data.inertia.mass = mass;
    data.inertia.inertia = 1e-4 * Mat3::Identity();
    data.inertia.integration = ToolIntegration::midpoint;
    const auto body = make_prefetched_tool(kVersion, data, test::thin_boxes(5));
    BodyMemory memory;
    memory.placed = true;
    memory.pose.position = Vec3(0.0, 0.0, 0.0412);
    std::uint64_t cut = 0, shortened = 0, complete = 0;
    for (int n = 0; n < 12; ++n) {
      const Pose device{Vec3(0.0002 * n, 0.0, 0.0412 - 0.001 * n), {1, 0, 0, 0}};
      const auto step = [&](BodyMemory& of, WorkLimit& work) {
        of.known = false;
        const CoupledTool tool{body->coupling, body->radius, false, &body->inertia, &work};
        return step_coupled_tool(tool, *body->solids, device, kTick, of).command;
      };
      BodyMemory whole = memory;
      WorkLimit unlimited(WorkLimit::kUnlimited);
      const Command felt = step(whole, unlimited);
      const std::uint64_t needed = unlimited.done();
      for (std::uint64_t limit = 0; limit <= 6 * needed; limit += 7) {
        BodyMemory after = memory, before = memory;
        before.known = false;
        WorkLimit work(limit);
        const Command command = step(after, work);
        ASSERT_LE(work.done(), limit);
        if (work.cut()) {
          ASSERT_TRUE(same(after, before)) << limit << " of " << needed;
          ++cut;
          continue;
        }
        ASSERT_TRUE(command.finite());
        const bool equal = same(after, whole);
        ++(equal ? complete : shortened);
        if (limit >= 5 * needed) {
          ASSERT_TRUE(equal && command == felt) << limit << " of " << needed;
        }
        if (mass == 0.0) {
          ASSERT_LE(energy_at(*body, device, after.pose),
                    energy_at(*body, device, memory.pose) * (1.0 + 1e-9));
        }
      }
      memory = whole;
    }
    EXPECT_GT(cut, 100u);
    EXPECT_GT(shortened, 10u);
    EXPECT_GT(complete, 100u);
  }
}

struct Lie {
  const char* name;
  SurfaceData surface;
};
std::vector<Lie> lies() {
  constexpr std::size_t kTriangles = 20'000;
  return {{"a point through a knot of triangles", test::through_a_point(kTriangles)},
          {"a ball through it", with_radius(test::through_a_point(kTriangles), 2e-3)},
          {"a point at a corner of many triangles", test::round_a_corner(kTriangles)},
          {"a ball at it", with_radius(test::round_a_corner(kTriangles), 2e-3)}};
}

/// Returns a model with contact on the surface at `place`.
LocalModel marked(const Vec3& place) {
  LocalModel model;
  model.surfaces = kVersion;
  model.center = place;
  model.reach = 0.1;
  model.count = 1;
  SurfacePatch& patch = model.patches[0];
  patch.point = patch.anchor = place;
  patch.whole = patch.touching = true;
  patch.material = kMaterial;
  return model;
}

/// A tick must stay within its limit and must not allocate, for any false surface from a server.
/// The model of a stopped tick must have no weight.
TEST(WorkLimit, NoSurfaceTakesMoreThanATickHas) {
  for (const Lie& lie : lies()) {
    const auto surfaces = mesh_surfaces(kVersion, {lie.surface});
    LocalContact contact;
    contact.use(surfaces.get());
    std::uint64_t cut = 0;
    const std::size_t before = test::allocations();
    for (int n = 0; n < 40; ++n) {
      const Vec3 place(1e-4 * n, 0.0, 2e-3 - 2e-4 * n);
      if (n % 5 == 0) contact.take(marked(place));
      WorkLimit work(kMost);
      const LocalForce force = contact.touch({place, Vec3::Zero()}, 0.0, kTick, &work);
      ASSERT_LE(work.done(), kMost);
      ASSERT_EQ(force.cut, work.cut());
      if (!force.cut) continue;
      ++cut;
      ASSERT_EQ(force.weight, 0.0);
      ASSERT_TRUE(force.command == Command{});
    }
    EXPECT_EQ(test::allocations(), before) << lie.name;
    EXPECT_GT(cut, 0u) << lie.name;
  }
}

/// A tick is stopped by its work limit. The next tick with a sufficient limit must use the contact
/// memory of the model, like a new contact.
TEST(WorkLimit, AfterACutTickTheModelsMemoryIsTaken) {
  const auto surfaces = mesh_surfaces(kVersion, {ring()});
  LocalContact cut_once, fresh;
  const Vec3 place(0.05, 0.0, 0.0195);
  for (LocalContact* contact : {&cut_once, &fresh}) {
    contact->use(surfaces.get());
    contact->take(marked(place));
  }
  cut_once.touch({place - Vec3(0, 0, 1e-3), Vec3::Zero()}, 0.0, kTick);
  WorkLimit nothing(0);
  EXPECT_TRUE(cut_once.touch({place - Vec3(0, 0, 2e-3), Vec3::Zero()}, 0.0, kTick, &nothing).cut);
  const Tool tool{place - Vec3(1e-4, 0, 3e-3), Vec3::Zero()};
  const LocalForce after = cut_once.touch(tool, 0.0, kTick), first = fresh.touch(tool, 0.0, kTick);
  EXPECT_EQ(after.weight, 1.0);
  EXPECT_GT(after.command.force().norm(), 1.0);
  EXPECT_TRUE(after.command == first.command);
}

BodyModel held_at(const Vec3& place, const PrefetchedTool& body) {
  BodyModel model;
  model.solids = kVersion;
  model.tool.position = place;
  model.reach = 0.1;
  model.turn = 1.0;
  model.coupling = body.coupling;
  model.radius = body.radius;
  return model;
}

/// 20,000 points against 150 thin boxes, at any tool position from the server.
TEST(WorkLimit, NoBodyTakesMoreThanATickHas) {
  const auto body =
      make_prefetched_tool(kVersion, test::ball_of_points(20'000), test::thin_boxes(150));
  LocalBody local;
  local.use(body.get());
  std::uint64_t cut = 0;
  const std::size_t before = test::allocations();
  for (int n = 0; n < 30; ++n) {
    const Vec3 place(0.002 * n - 0.03, 0.0, 0.042 - 0.002 * n);
    local.take(held_at(place, *body));
    for (int tick = 0; tick < 2; ++tick) {
      WorkLimit work(kMost);
      const BodyForce force =
          local.touch({place - Vec3(0, 0, 1e-3 * tick), {1, 0, 0, 0}}, 0.0, kTick, &work);
      ASSERT_LE(work.done(), kMost);
      ASSERT_EQ(force.cut, work.cut());
      if (!force.cut) continue;
      ++cut;
      ASSERT_EQ(force.weight, 0.0);
      ASSERT_TRUE(force.command == Command{});
      // The client must do no more work until the server sends the tool's position.
      WorkLimit next(kMost);
      EXPECT_EQ(local.touch({place, {1, 0, 0, 0}}, 0.0, kTick, &next).weight, 0.0);
      EXPECT_EQ(next.done(), 0u);
      break;
    }
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(cut, 10u);
}

/// A server may send planes with any friction. The search for the holding friction must count too.
TEST(WorkLimit, NoModelOfPlanesTakesMoreThanATickHas) {
  LocalBody local;
  BodyModel model = held_at(Vec3::Zero(), {.version = 0,
                                           .coupling = {1000.0, 1.0, 20.0, 1.0},
                                           .radius = 0.04,
                                           .inertia = {},
                                           .solids = nullptr,
                                           .ways = {}});
  model.solids = 0;
  model.count = kMaxBodyPoints;
  model.patch_count = kMaxBodyPatches;
  for (int i = 0; i < model.count; ++i) {
    BodyPoint& point = model.points[static_cast<std::size_t>(i)];
    point = {.arm = 0.04 * test::spread_direction(static_cast<std::size_t>(i), 15),
             .spread = 1e-6 * Mat3::Identity(),
             .normal = test::spread_direction(static_cast<std::size_t>(3 * i % 15), 15),
             .distance = -1e-3,
             .stiffness = 1e3,
             .patch = static_cast<std::uint8_t>(i % kMaxBodyPatches)};
  }
  for (BodyPatch& patch : model.patches) {
    patch.static_friction = 1.0;
    patch.dynamic_friction = 0.5;
    patch.velocity = Vec3(0.3, 0.2, 0.1);
  }
  std::uint64_t most = 0;
  for (int n = 0; n < 50; ++n) {
    local.take(model);
    WorkLimit unlimited(WorkLimit::kUnlimited);
    local.touch({Vec3(1e-3 * n, 5e-4 * n, 0), {1, 0, 0, 0}}, 0.0, kTick, &unlimited);
    most = std::max(most, unlimited.done());
    local.clear();
    local.take(model);
    WorkLimit few(200);
    EXPECT_TRUE(local.touch({Vec3(1e-3 * n, 5e-4 * n, 0), {1, 0, 0, 0}}, 0.0, kTick, &few).cut);
    EXPECT_LE(few.done(), 200u);
    local.clear();
  }
  EXPECT_GT(most, 1000u);  // Without a limit the work would be large.
}

/// The trial positions must find too expensive geometry. A usual mesh and a usual tool must pass.
TEST(ContactTrial, FindsWhatTakesTooMuch) {
  const auto most_of = [](const FetchedScene& scene) {
    std::uint64_t most = 0, ticks = 0;
    try_contact(scene, kTick, [&](const TrialTick& tick) {
      WorkLimit work(kMost), again(kMost);
      tick.evaluate(work);
      tick.evaluate(again);
      EXPECT_EQ(work.done(), again.done());  // Both runs start with equal memory.
      most = std::max(most, work.done());
      ++ticks;
      return !work.cut();
    });
    EXPECT_GT(ticks, 0u);
    return most;
  };
  for (const Lie& lie : lies())
    EXPECT_EQ(
        most_of(
            {.objects = {0}, .surfaces = mesh_surfaces(kVersion, {lie.surface}), .body = nullptr}),
        kMost)
        << lie.name;
  EXPECT_LT(
      most_of({.objects = {0}, .surfaces = mesh_surfaces(kVersion, {ring()}), .body = nullptr}),
      kMost / 4);
  const auto of_body = [&](std::size_t points, std::size_t boxes) {
    return most_of({.objects = {0},
                    .surfaces = nullptr,
                    .body = make_prefetched_tool(kVersion, test::ball_of_points(points),
                                                 test::thin_boxes(boxes))});
  };
  EXPECT_EQ(of_body(20'000, 150), kMost);
  EXPECT_LT(of_body(1000, 3), kMost);
}

}  // namespace
}  // namespace feltwire::work_limit_test
