// A corner has one channel for each wall. Tests how the walls share the damping, in closed form and
// against a hand that extracts the most energy.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/bounding/credited.hpp"
#include "core/bounding/multi_contact_frame.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::corner_test {
namespace {

constexpr double kPeriod = 1e-3;                         // [s]
constexpr double kDamping = 0.5;                         // b [N s/m]
constexpr double kStiffness = 2.0 * kDamping / kPeriod;  // c [N/m] without credited damping

/// Returns a method that assumes `share` times the device's damping.
Credited<double> law(double share = 1.0) {
  return {{.damping = share * kDamping}, {}, kPeriod, 0.0, false};
}

ContactNormals normals(std::initializer_list<Vec3> walls) {
  ContactNormals n;
  for (const Vec3& wall : walls) n.add(wall.normalized());
  return n;
}

class Hand {
 public:
  explicit Hand(std::uint64_t seed) : random_(seed) {}
  double number() { return std::normal_distribution<double>()(random_); }
  Vec3 vector() { return {number(), number(), number()}; }
  ContactNormals walls() {
    ContactNormals n;
    const int wanted = number() > 0.0 ? 2 : 3;
    while (n.count < wanted) n.add(vector().normalized());
    return n;
  }

 private:
  std::mt19937 random_;
};

BoundingStep step(const Vec3& dx, const Command& command, const ContactNormals& walls) {
  return {.displacement = dx, .hold_time = kPeriod, .command = command, .normals = &walls};
}
Command push(const Vec3& force) { return {.elastic = force}; }

TEST(Corner, EachWallRisesAndFallsWithItsOwnMovement) {
  auto credited = law();
  const ContactNormals walls = normals({Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()});
  Vec3 given = credited.step(step({-1e-3, -2e-3, -3e-3}, push({9, 9, 9}), walls)).elastic;
  EXPECT_LT((given - kStiffness * Vec3(1e-3, 2e-3, 3e-3)).norm(), 1e-12);
  given = credited.step(step({4e-4, -4e-4, 0.0}, push({9, 9, 9}), walls)).elastic;
  EXPECT_LT((given - kStiffness * Vec3(6e-4, 2.4e-3, 3e-3)).norm(), 1e-12);
}

TEST(Corner, AWallThatIsLeftTakesNothingFromTheOther) {
  auto apart = law(), together = law();
  const ContactNormals both = normals({Vec3::UnitX(), Vec3::UnitZ()});
  const ContactNormals none;
  const auto run = [&](Credited<double>& law, const ContactNormals& walls) {
    law.step(step({-3e-3, 0.0, -3e-3}, push({3.0, 0.0, 3.0}), walls));
    Vec3 given = Vec3::Zero();
    // The hand leaves one wall and enters it again, along the other wall.
    for (int n = 0; n < 10; ++n)
      for (const double x : {3e-3, -3e-3})
        given = law.step(step({x, 0.0, 0.0}, push({x > 0.0 ? 0.0 : 3.0, 0.0, 3.0}), walls)).elastic;
    return given;
  };
  EXPECT_LT((run(apart, both) - Vec3(3.0, 0.0, 3.0)).norm(), 1e-12);
  EXPECT_LT(run(together, none).norm(), 3.0) << "one channel loses the wall that stays";
}

TEST(Corner, OneNormalIsAsNone) {
  auto told = law(), untold = law();
  const ContactNormals one = normals({Vec3::UnitZ()});
  Hand hand(1);
  for (int n = 0; n < 1000; ++n) {
    BoundingStep s = step(1e-3 * hand.vector(), {}, one);
    s.command = {.elastic = hand.vector(), .frictional = hand.vector()};
    const Command a = told.step(s);
    s.normals = nullptr;
    EXPECT_EQ(a, untold.step(s));
  }
}

TEST(Corner, FrictionAlongBothWallsHasAChannelOfItsOwn) {
  auto credited = law();
  const ContactNormals walls = normals({Vec3::UnitX(), Vec3::UnitZ()});
  const Command wanted{.elastic = {1.0, 0.0, 1.0}, .frictional = {0.0, -2.0, 0.0}};
  const Command given = credited.step(step({-5e-3, 1e-3, -5e-3}, wanted, walls));
  EXPECT_LT((given.elastic - wanted.elastic).norm(), 1e-12);
  EXPECT_NEAR(given.frictional.y(), -kStiffness * 1e-3, 1e-12);
}

TEST(Corner, WallsThatHardlyStandOutAreLeftOut) {
  ContactNormals n;
  EXPECT_TRUE(n.add(Vec3::UnitX()));
  EXPECT_FALSE(n.add(Vec3(1.0, 0.19, 0.0).normalized()));
  EXPECT_FALSE(n.add(-Vec3::UnitX()));
  EXPECT_TRUE(n.add(Vec3(1.0, 0.3, 0.0).normalized()));
  EXPECT_FALSE(n.add(Vec3(0.5, -0.5, 0.1).normalized()));
  EXPECT_TRUE(n.add(Vec3::UnitZ()));
  EXPECT_FALSE(n.add(Vec3(1.0, 1.0, 1.0).normalized())) << "three are all";
}

TEST(Corner, AForceIsTheSumOfItsWallsAndWhatIsAcross) {
  Hand hand(2);
  for (int n = 0; n < 2000; ++n) {
    const MultiContactFrame<double> walls(hand.walls());
    const Vec3 force = hand.vector();
    Vec3 sum = walls.across(force);
    for (int i = 0; i < walls.count(); ++i) sum += walls.part(i, force) * walls.normal(i);
    EXPECT_LT((sum - force).norm(), 1e-12 * force.norm() * 100.0);
  }
}

double shares(const MultiContactFrame<double>& walls, const Vec3& dx) {
  double sum = walls.across(dx).squaredNorm();
  for (int i = 0; i < walls.count(); ++i)
    sum += walls.weight(i) * walls.normal(i).dot(dx) * walls.normal(i).dot(dx);
  return sum;
}

TEST(Corner, TheSharesOfAMovementAreNeverMoreThanIt) {
  Hand hand(3);
  for (int n = 0; n < 20'000; ++n) {
    const MultiContactFrame<double> walls(hand.walls());
    const Vec3 dx = hand.vector();
    EXPECT_LE(shares(walls, dx), dx.squaredNorm() * (1.0 + 1e-12));
  }
}

TEST(Corner, NoLargerWeightsWouldDo) {
  for (const double angle : {0.3, 1.0, 1.57, 2.0, 2.8}) {
    const Vec3 other(std::cos(angle), std::sin(angle), 0.0);
    const MultiContactFrame<double> walls(normals({Vec3::UnitX(), other}));
    const Vec3 dx = angle < 1.6 ? Vec3(Vec3::UnitX() + other) : Vec3(Vec3::UnitX() - other);
    EXPECT_NEAR(shares(walls, dx), dx.squaredNorm(), 1e-3 * dx.squaredNorm()) << angle;
  }
}

/// Returns the energy that a hand extracts from random walls and commands beyond the dissipated
/// energy, divided by the exchanged energy. Half of the hand's movements extract the most energy
/// from the held force.
double excess(double told, std::uint64_t seed) {
  Hand hand(seed);
  auto credited = law(told);
  const ContactNormals walls = hand.walls();
  Vec3 held = Vec3::Zero();
  double left = 0.0, least = 0.0, exchanged = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 dx =
        hand.number() > 0.0 ? Vec3(kPeriod / (2.0 * kDamping) * held) : Vec3(1e-3 * hand.vector());
    left += kDamping / kPeriod * dx.squaredNorm() - held.dot(dx);
    exchanged += std::abs(held.dot(dx));
    least = std::min(least, left);
    Command wanted;
    for (int i = 0; i < walls.count; ++i)
      wanted.elastic += std::exp(3.0 * hand.number()) * walls.unit[static_cast<std::size_t>(i)];
    if (walls.count == 2)
      wanted.frictional = hand.number() * walls.unit[0].cross(walls.unit[1]).normalized();
    held = credited.step(step(dx, wanted, walls)).force();
  }
  return -least / exchanged;
}

TEST(Corner, WithoutCreditNoHandTakesMoreThanIsBurned) {
  for (const std::uint64_t seed : test::seeds(0, 200, 0))
    EXPECT_LE(excess(1.0, seed), 1e-12) << seed;
}

TEST(Corner, ToldOfMoreDampingItLoses) {
  double worst = 0.0;
  for (const std::uint64_t seed : test::seeds(0, 50, 0)) worst = std::max(worst, excess(1.5, seed));
  EXPECT_GT(worst, 1e-3);
}

}  // namespace
}  // namespace feltwire::corner_test
