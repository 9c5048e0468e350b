// A robot touches several surfaces in turn.

#include "core/teleoperation/surface_memory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "core/base/numeric.hpp"
#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/surface_offset.hpp"
#include "core/teleoperation/target_limiter.hpp"

namespace feltwire::surface_memory_test {
namespace {

constexpr double kPeriod = 1e-3;       // [s]
constexpr double kStiffness = 2000.0;  // [N/m]
constexpr double kPlay = 0.25e-3;      // [m] clearance of a tool in a slot, on each side
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Two walls perpendicular to x, or a single wall.
struct Slot {
  bool left = true, right = true;
  Vec3 force(const Vec3& tip) const {
    double push = 0.0;
    if (right) push -= kStiffness * std::max(0.0, tip.x() - kPlay);
    if (left) push += kStiffness * std::max(0.0, -kPlay - tip.x());
    return {push, 0.0, 0.0};
  }
};

/// A tool that moves along x [m].
class Tool {
 public:
  explicit Tool(ContactEstimator& estimate) : estimate_(estimate) {}
  const RemoteContact& at(const Slot& slot, double x) {
    const Vec3 tip(x, 0.0, 0.0);
    const Vec3 velocity = (tip - before_) / kPeriod;
    before_ = tip;
    return estimate_.step({tip, velocity, slot.force(tip), kPeriod});
  }
  /// Moves at a constant speed.
  void go(const Slot& slot, double from, double to, double speed) {
    const int steps = static_cast<int>(std::abs(to - from) / (speed * kPeriod));
    for (int n = 1; n <= steps; ++n) at(slot, from + (to - from) * n / steps);
  }

 private:
  ContactEstimator& estimate_;
  Vec3 before_ = Vec3::Zero();
};

/// Returns all surfaces that the hand gets.
std::vector<RemoteContact> told(const ContactEstimator& estimate) {
  std::vector<RemoteContact> all(estimate.others().view().begin(), estimate.others().view().end());
  if (estimate.contact().surface != 0) all.push_back(estimate.contact());
  return all;
}

/// Returns the force of these surfaces on a tool at `tip`.
Vec3 force_of(const std::vector<RemoteContact>& surfaces, const Vec3& tip) {
  Vec3 force = Vec3::Zero();
  for (const RemoteContact& s : surfaces)
    force += s.stiffness * std::max(0.0, (s.point - tip).dot(s.normal)) * s.normal;
  return force;
}

TEST(SurfaceMemory, BothWallsOfASlotAreKnownAfterOneVisitEach) {
  // [m], [Hz] movement of the tool from side to side
  constexpr double kWay = 0.75e-3, kTurns = 2.0;
  ContactEstimator estimate({});
  Tool tool(estimate);
  const auto x = [](int n) { return kWay * std::sin(kTwoPi * kTurns * n * kPeriod); };
  const int round = static_cast<int>(1.0 / (kTurns * kPeriod));
  for (int n = 0; n < round; ++n) tool.at({}, x(n));
  const auto known = told(estimate);
  ASSERT_EQ(known.size(), 2u);
  for (const RemoteContact& wall : known) {
    EXPECT_NEAR(std::abs(wall.normal.x()), 1.0, 1e-9);
    EXPECT_NEAR(wall.point.x(), -kPlay * wall.normal.x(), 1e-5);
    EXPECT_NEAR(wall.stiffness, kStiffness, 0.01 * kStiffness);
  }
  EXPECT_LT(known[0].normal.dot(known[1].normal), 0.0);
  // On the second visits, the reported surfaces must give the force before the tool touches.
  for (int n = round; n < 3 * round; ++n) {
    const Vec3 tip(x(n), 0.0, 0.0), force = Slot{}.force(tip);
    EXPECT_LT(length(Vec3(force_of(told(estimate), tip) - force)), 0.03) << n;
    tool.at({}, tip.x());
  }
  EXPECT_EQ(estimate.newest(), 2u) << "no visit opened a third surface";
}

/// The tool moves from one wall into the other within a sample. The touch must continue.
TEST(SurfaceMemory, AForceFromTheOtherSideIsOfAnotherSurface) {
  ContactEstimator estimate({});
  Tool tool(estimate);
  tool.go({}, kPlay, 1e-3, 0.01);
  const RemoteContact& seen = tool.at({}, -1e-3);
  EXPECT_TRUE(seen.touching);
  EXPECT_EQ(seen.surface, 2u);
  EXPECT_GT(seen.normal.x(), 0.99);
  ASSERT_EQ(estimate.others().count, 1);
  EXPECT_EQ(estimate.others().surfaces[0].surface, 1u);
  EXPECT_LT(estimate.others().surfaces[0].normal.x(), -0.99);
}

/// A load has no measurable stiffness. A push against the load must count as another surface only
/// after a gap.
TEST(SurfaceMemory, APushAgainstALoadIsNoOtherSurface) {
  for (const bool gap : {false, true}) {
    ContactEstimator estimate({});
    const auto feel = [&](const Vec3& force, int samples) {
      for (int n = 0; n < samples; ++n) estimate.step({Vec3::Zero(), Vec3::Zero(), force, kPeriod});
    };
    const Vec3 weight(0.0, 0.0, -0.6);
    feel(weight, 500);
    if (gap) feel(Vec3::Zero(), 2);
    feel(weight + Vec3(2.0, 0.0, 0.5), 5);
    EXPECT_EQ(estimate.newest(), gap ? 2u : 1u);
  }
}

/// A tool falls along a wall with short touches. Friction tilts each force by 17 degrees.
TEST(SurfaceMemory, TheWayBetweenTwoTouchesLiesInTheSurface) {
  constexpr double kFriction = 0.3, kFall = 0.1, kDeep = 1e-3;  // mu, [m/s], [m]
  constexpr double kInAndOut = 0.04, kBetween = 0.05;           // [s]
  ContactEstimator estimate({});
  double tilt[2] = {};
  double time = 0.0;
  for (double& seen : tilt) {
    const double begin = time;
    for (; time < begin + kInAndOut + kBetween; time += kPeriod) {
      const double turn = kTwoPi / (2.0 * kInAndOut), now = time - begin;
      const double depth = now < kInAndOut ? kDeep * std::sin(turn * now) : -1e-4;
      const double speed = now < kInAndOut ? kDeep * turn * std::cos(turn * now) : 0.0;
      const double normal = kStiffness * std::max(0.0, depth);
      estimate.step({Vec3(depth, 0.0, -kFall * time), Vec3(speed, 0.0, -kFall),
                     Vec3(-normal, 0.0, kFriction * normal), kPeriod});
    }
    seen = std::asin(std::abs(estimate.contact().normal.z()));
  }
  constexpr double kDegree = std::numbers::pi / 180.0;
  EXPECT_GT(tilt[0], 5.0 * kDegree);
  EXPECT_LT(tilt[1], 3.0 * kDegree);
  EXPECT_EQ(estimate.newest(), 1u);
}

TEST(SurfaceMemory, AWallThatIsGoneIsForgotten) {
  for (const bool gone : {false, true}) {
    ContactEstimator estimate({});
    Tool tool(estimate);
    tool.go({}, 0.0, 1e-3, 0.01);
    tool.go({}, 1e-3, -1e-3, 0.01);
    tool.go({}, -1e-3, kPlay, 0.01);
    ASSERT_EQ(told(estimate).size(), 2u);
    const Slot left{.right = !gone};
    // The tool moves until 10 ms after the wall would press with 0.4 N. The estimator needs exactly
    // this time.
    constexpr double kSpeed = 0.01;
    const double clear = SurfaceMemory::kClear / kStiffness, speed = kSpeed;
    const double after = SurfaceMemory::kAbsent * speed;
    tool.go(left, kPlay, kPlay + clear + after + 2.0 * speed * kPeriod, speed);
    EXPECT_EQ(told(estimate).size(), gone ? 1u : 2u);
    tool.go(left, kPlay + clear + after, 0.0, speed);
    EXPECT_EQ(told(estimate).size(), gone ? 1u : 2u);
  }
}

TEST(SurfaceMemory, ATouchOfAnotherSurfaceIsNoWitnessForThisOne) {
  // The tool is below the plane of an old surface, but this surface ends before the tool.
  SurfaceMemory memory;
  std::uint32_t counted = 1;
  memory.keep({.contact = {.surface = 1, .normal = Vec3::UnitX(), .stiffness = kStiffness}},
              Vec3::Zero());
  const Vec3 inside(-1e-3, 0.0, 0.0), from_below(0.0, 0.0, 5.0);
  for (int n = 0; n < 9; ++n) memory.step(inside, from_below, kPeriod, counted);
  EXPECT_EQ(memory.told().count, 1);
  memory.step(inside, Vec3(2.0, 0.0, 5.0), kPeriod, counted);  // Both walls press.
  for (int n = 0; n < 9; ++n) memory.step(inside, from_below, kPeriod, counted);
  EXPECT_EQ(memory.told().count, 1);
  for (int n = 0; n < 2; ++n) memory.step(inside, from_below, kPeriod, counted);
  EXPECT_EQ(memory.told().count, 0);
}

TEST(SurfaceMemory, FrictionOpensNoSecondSurface) {
  for (const double mu : {0.1, 0.3, 0.5})
    for (const double speed : {0.003, 0.05}) {
      ContactEstimator estimate({});
      const double depth = 1e-3;
      for (int n = 0; n < 4000; ++n) {
        const double turn = kTwoPi * 1.0 * n * kPeriod;
        const Vec3 velocity = speed * Vec3(std::cos(turn), std::sin(2.0 * turn), 0.0);
        const Vec3 tip(speed / kTwoPi * std::sin(turn), 0.0, -std::min(depth, 1e-5 * n));
        const double normal = -kStiffness * tip.z();
        const Vec3 force = normal * Vec3::UnitZ() - mu * normal * direction(velocity);
        estimate.step({tip, velocity, force, kPeriod});
      }
      EXPECT_EQ(estimate.newest(), 1u) << mu << ' ' << speed;
    }
}

/// Walls surround the tool. The tool touches each wall once.
TEST(SurfaceMemory, TheNumberOfSurfacesIsBounded) {
  SurfaceMemory memory;
  std::uint32_t counted = 0;
  constexpr double kAround = 10e-3;  // [m]
  constexpr int kWalls = 40;
  for (int n = 0; n < kWalls; ++n) {
    const double turn = kTwoPi * n / kWalls;
    const Vec3 out(std::cos(turn), std::sin(turn), 0.0);
    memory.keep({.contact = {.surface = ++counted,
                             .point = kAround * out,
                             .normal = -out,
                             .stiffness = kStiffness}},
                kAround * out);
    memory.step(kAround * out, Vec3::Zero(), kPeriod, counted);
    EXPECT_LE(memory.told().count, OtherSurfaces::kMost);
  }
  std::size_t found = 0;
  for (int n = 0; n < kWalls; ++n) {
    const double turn = kTwoPi * n / kWalls;
    const Vec3 out(std::cos(turn), std::sin(turn), 0.0);
    while (memory.take(kAround * out, -out, 1e-4)) ++found;
  }
  EXPECT_EQ(found, SurfaceMemory::kRemembered);
}

TEST(SurfaceMemory, TheNearestAreTold) {
  SurfaceMemory memory;
  std::uint32_t counted = 3;
  for (std::uint32_t n = 1; n <= 3; ++n)
    memory.keep({.contact = {.surface = n,
                             .point = Vec3(0.01 * n, 0.0, 0.0),
                             .normal = -Vec3::UnitX(),
                             .stiffness = kStiffness}},
                Vec3::Zero());
  memory.step(Vec3::Zero(), Vec3::Zero(), kPeriod, counted);
  ASSERT_EQ(memory.told().count, 2);
  EXPECT_EQ(memory.told().surfaces[0].surface, 1u);
  EXPECT_EQ(memory.told().surfaces[1].surface, 2u);
  // The memory has dropped the third surface. When the surface is reported again, it must get a new
  // number.
  const Vec3 there(0.0, 0.045, 0.0);  // too far from the first two
  EXPECT_EQ(counted, 3u);
  memory.take(Vec3::Zero(), -Vec3::UnitX(), 0.011);
  memory.step(Vec3::Zero(), Vec3::Zero(), kPeriod, counted);
  ASSERT_EQ(memory.told().count, 2);
  EXPECT_EQ(memory.told().surfaces[0].surface, 2u);
  EXPECT_EQ(memory.told().surfaces[1].surface, 4u);
  EXPECT_EQ(counted, 4u);
  memory.step(there, Vec3::Zero(), kPeriod, counted);
  EXPECT_EQ(memory.told().count, 1);
  memory.step(Vec3(0.0, 0.1, 0.0), Vec3::Zero(), kPeriod, counted);
  EXPECT_EQ(memory.told().count, 0);
}

TEST(SurfaceMemory, AFollowerThatLiesBreaksNothing) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  std::mt19937_64 random(7);
  const auto any = [&](double most) {
    std::uniform_real_distribution<double> place(-most, most);
    return Vec3(place(random), place(random), place(random));
  };
  ContactEstimator estimate({});
  std::uint32_t newest = 0;
  for (int n = 0; n < 100'000; ++n) {
    const int lie = static_cast<int>(random() % 8);
    Vec3 tip = any(5e-3), velocity = any(0.1), force = any(5.0);
    if (lie == 0) force = any(1e9);
    if (lie == 1) tip = any(1e9);
    if (lie == 2) velocity = any(1e9);
    if (lie == 3) force.x() = kNan;
    if (lie == 4) tip.y() = kNan;
    if (lie == 5) force.setZero();
    if (lie == 6) tip = any(1.0);
    estimate.step({tip, velocity, force, kPeriod});
    std::set<std::uint32_t> numbers;
    for (const RemoteContact& s : told(estimate)) {
      ASSERT_TRUE(s.point.allFinite() && s.velocity.allFinite());
      ASSERT_NEAR(length(s.normal), 1.0, 1e-9);
      ASSERT_TRUE(s.stiffness > 0.0 && s.stiffness <= 1e6 && s.friction >= 0.0);
      ASSERT_TRUE(s.surface <= estimate.newest() && numbers.insert(s.surface).second);
    }
    ASSERT_LE(estimate.others().count, OtherSurfaces::kMost);
    ASSERT_GE(estimate.newest(), newest);
    newest = estimate.newest();
  }
}

RemoteContact wall_at(double x, double normal, std::uint32_t surface, bool touching) {
  return {.surface = surface,
          .touching = touching,
          .point = Vec3(x, 0.0, 0.0),
          .normal = normal * Vec3::UnitX(),
          .stiffness = kStiffness};
}

/// The hand changes between two known walls. The offset must stay, so the force belongs to the
/// wall.
TEST(SurfaceOffset, AKnownWallIsMetWhereItIs) {
  SurfaceOffset index;
  const RemoteContact right = wall_at(kPlay, -1.0, 1, true);
  const Vec3 deep(5e-3, 0.0, 0.0);
  index.step(deep, Vec3::Zero(), right, kPeriod);
  EXPECT_NEAR(index.offset().x(), 5e-3 - kPlay, 1e-15) << "the first touch is at the hand";
  EXPECT_EQ(index.known_surface(), 1u);
  const Vec3 offset = index.offset();
  // The left wall is reported while the hand is in front of it.
  OtherSurfaces others;
  others.count = 1;
  others.surfaces[0] = right;
  others.surfaces[0].touching = false;
  index.step(deep, Vec3::Zero(), wall_at(-kPlay, 1.0, 2, true), kPeriod, {}, others);
  EXPECT_EQ(index.known_surface(), 2u);
  EXPECT_TRUE(index.offset().isApprox(offset));
  // The hand moves back and forth, half a millimetre into each wall. Both walls are known.
  for (int n = 0; n < 10; ++n) {
    const bool on_right = n % 2 == 0;
    others.surfaces[0] = on_right ? wall_at(-kPlay, 1.0, 2, false) : wall_at(kPlay, -1.0, 1, false);
    const Vec3 hand = offset + Vec3((on_right ? 1.0 : -1.0) * (kPlay + 5e-4), 0.0, 0.0);
    index.step(hand, Vec3::Zero(),
               on_right ? wall_at(kPlay, -1.0, 1, true) : wall_at(-kPlay, 1.0, 2, true), kPeriod,
               {}, others);
    EXPECT_TRUE(index.offset().isApprox(offset)) << n;
    EXPECT_EQ(index.known_surface(), 2u);
  }
}

TEST(SurfaceOffset, AnUnknownSurfaceBesideTheContactIsMetAtTheHandToo) {
  SurfaceOffset index;
  const RemoteContact right = wall_at(0.0, -1.0, 1, true);
  index.step(Vec3(1e-3, 0.0, 0.0), Vec3::Zero(), right, kPeriod);
  OtherSurfaces others;
  others.count = 1;
  others.surfaces[0] = {.surface = 2, .normal = Vec3::UnitZ(), .stiffness = kStiffness};
  const Vec3 hand(1e-3, 0.0, -4e-3);
  index.step(hand, Vec3::Zero(), right, kPeriod, {}, others);
  EXPECT_NEAR(index.offset().z(), -4e-3, 1e-15);
  EXPECT_NEAR(index.offset().x(), 1e-3, 1e-15);
  EXPECT_EQ(index.known_surface(), 2u);
}

/// Free motion must reduce the offset only while the hand is in front of all surfaces.
TEST(SurfaceOffset, NothingIsGivenBackBesideAnotherSurface) {
  for (const double near : {1e-3, 1e-2}) {
    SurfaceOffset index;
    RemoteContact floor{.surface = 1, .touching = true, .normal = Vec3::UnitZ(), .stiffness = 1e3};
    index.step(Vec3(0, 0, -2e-3), Vec3::Zero(), floor, kPeriod);
    floor.touching = false;
    OtherSurfaces others;
    others.count = 1;
    others.surfaces[0] = wall_at(near, -1.0, 2, false);
    for (int n = 0; n < 200; ++n) index.step(Vec3(0, 0, 0.05), Vec3::Zero(), floor, kPeriod);
    index.step(Vec3(0, 0, 0.05), Vec3::Zero(), floor, kPeriod, {}, others);
    const double before = length(index.offset());
    index.step(Vec3(0, 0, 0.06), Vec3(0, 0, 5e-3), floor, kPeriod, {}, others);
    EXPECT_EQ(length(index.offset()) < before, near > SurfaceOffset::kFreeAbove) << near;
  }
}

TEST(TargetLimiter, ARememberedSurfaceIsNoFirstTouch) {
  const TargetLimits limits{.stiffness = 1000.0, .speed = 1e3, .unfelt = 20.0};
  for (const std::uint32_t known : {0u, 1u, 2u, 7u}) {
    TargetLimiter limiter(limits);
    limiter.step({});
    const Vec3 target = limiter.step({.wanted = Vec3(0.01, 0, 0), .surface = 2, .known = known});
    EXPECT_NEAR(target.x(), known < 2 ? 0.003 : 0.01, 1e-12) << known;
  }
}

}  // namespace
}  // namespace feltwire::surface_memory_test
