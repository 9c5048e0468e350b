// The client measures contact with fetched geometry before the servo uses it. The client must
// refuse geometry that takes too long.

#include "client/transport/contact_cost.hpp"

#include <gmock/gmock.h>

#include "core/mesh/tessellation.hpp"
#include "core/prefetched_geometry/make_prefetched_tool.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"
#include "tests/core/heavy_geometry.hpp"

namespace feltwire::contact_cost_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Optional;

constexpr double kPeriod = 1e-3;  // [s]

FetchedScene ring() {
  SurfaceData data;
  data.object = 3;
  const TriangleSoup soup = tessellate(Torus{0.05, 0.02}, 24);
  data.vertices = soup.vertices;
  data.triangles = soup.triangles;
  return {.objects = {3}, .surfaces = mesh_surfaces(1, {data}), .body = nullptr};
}

/// Returns a clock on which each evaluation takes this time. Reading the clock takes no time.
ComputingClock each_takes(Nanoseconds time) {
  return [=, now = Nanoseconds(0), reads = 0]() mutable {
    // The first readings measure the clock itself. Then every second reading ends an evaluation.
    constexpr int kFirst = 9;
    if (++reads > kFirst && (reads - kFirst) % 2 == 0) now += time;
    return now;
  };
}

TEST(ContactCost, WhatFitsAQuarterOfAPeriodIsTaken) {
  const ContactCost cost =
      contact_cost(ring(), kPeriod, each_takes(std::chrono::microseconds(200)));
  EXPECT_NEAR(cost.longest, 200e-6, 1e-9);
  EXPECT_FALSE(cost.cut);
  EXPECT_EQ(too_costly(cost, kPeriod), std::nullopt);
}

TEST(ContactCost, WhatTakesLongerIsRefusedWithItsTimeItsPlaceAndARemedy) {
  const ContactCost cost =
      contact_cost(ring(), kPeriod, each_takes(std::chrono::microseconds(312)));
  EXPECT_NEAR(cost.longest, 312e-6, 1e-9);
  EXPECT_THAT(too_costly(cost, kPeriod),
              Optional(AllOf(HasSubstr("object 3 "), HasSubstr("250 us"), HasSubstr("312 us"),
                             HasSubstr("fewer triangles"), HasSubstr("--rate"))));
  // A slower servo accepts this time, and a faster servo refuses it.
  EXPECT_EQ(too_costly(cost, 2 * kPeriod), std::nullopt);
  const ContactCost fast = contact_cost(ring(), 1e-4, each_takes(std::chrono::microseconds(30)));
  EXPECT_THAT(too_costly(fast, 1e-4), Optional(HasSubstr("25 us")));
}

/// A work unit takes longer on a slow machine. Fewer units fit into a tick.
TEST(ContactCost, AUnitIsAsLongAsItWasMeasured) {
  const ContactCost fast = contact_cost(ring(), kPeriod, each_takes(Nanoseconds(1)));
  EXPECT_EQ(fast.unit, kUsualUnit);
  const ContactCost slow =
      contact_cost(ring(), kPeriod, each_takes(std::chrono::microseconds(200)));
  EXPECT_GT(slow.unit, kUsualUnit);
  EXPECT_LT(units_within(contact_budget(kPeriod), slow.unit),
            units_within(contact_budget(kPeriod)));
}

/// The client must refuse geometry that exceeds the servo's budget, even if the measured time is
/// short.
TEST(ContactCost, WhatALyingServerSendsIsRefusedOnEveryMachine) {
  constexpr std::size_t kTriangles = 20'000;
  SurfaceData ball = test::through_a_point(kTriangles);
  ball.radius = 2e-3;
  const std::vector<FetchedScene> lies = {
      {.objects = {0},
       .surfaces = mesh_surfaces(1, {test::through_a_point(kTriangles)}),
       .body = nullptr},
      {.objects = {0}, .surfaces = mesh_surfaces(1, {ball}), .body = nullptr},
      {.objects = {0},
       .surfaces = mesh_surfaces(1, {test::round_a_corner(kTriangles)}),
       .body = nullptr},
      {.objects = {0},
       .surfaces = nullptr,
       .body = make_prefetched_tool(1, test::ball_of_points(20'000), test::thin_boxes(150))}};
  for (const FetchedScene& lie : lies) {
    const ContactCost cost = contact_cost(lie, kPeriod, each_takes(Nanoseconds(1)));
    EXPECT_TRUE(cost.cut) << &lie - lies.data();
    EXPECT_THAT(too_costly(cost, kPeriod), Optional(HasSubstr("250 us")));
  }
}

TEST(ContactCost, TheClockCountsWhatThisThreadComputes) {
  const Nanoseconds began = computing_time();
  volatile double sum = 0.0;
  while (computing_time() == began) sum = sum + 1.0;
  EXPECT_GT(computing_time(), began);
}

}  // namespace
}  // namespace feltwire::contact_cost_test
