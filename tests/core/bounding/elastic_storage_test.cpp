// Storage::elastic must return only the energy that the hand stored in a spring.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/core/contact_frame_fixture.hpp"

namespace feltwire::elastic_storage_test {
namespace {

using namespace test;

BoundingConfig elastic() { return contact_frame(Projection::cone, Storage::elastic); }

/// A hand moves in and out of a spring on the plane z = 0. `look` gets each command and result.
template <class ShellQuery>
void wander(const BoundingConfig& c, double stiffness, std::uint64_t seed, ShellQuery look) {
  Random random(seed);
  Bounding bounding(c);
  double depth = 0.0;
  for (int n = 0; n < 20000; ++n) {
    const double moved = random.decades(-7.0, -3.0);
    depth = std::min(depth + moved, 0.02);
    BoundingStep s;
    s.displacement.z() = -moved;
    s.hold_time = kPeriod;
    s.command.elastic.z() = stiffness * std::max(0.0, depth);
    look(s, bounding.step(s).rendered);
  }
}

TEST(ElasticStorage, EverySpringUpToColgatesLimitIsRenderedWhole) {
  for (const double share : {0.01, 0.1, 0.25, 0.5, 0.99, 1.0}) {
    wander(elastic(), share * kColgate, 1, [&](const BoundingStep& s, const Command& rendered) {
      const double wanted = s.command.elastic.z();
      // In the sample of the entry, a part of the movement is outside. The true work is therefore
      // at most the measured work.
      ASSERT_NEAR(rendered.elastic.z(), wanted, 1e-9 * (1.0 + wanted)) << share;
    });
  }
}

TEST(ElasticStorage, MinimalStorageLosesTheSameSpring) {
  double wanted = 0.0, given = 0.0;
  wander(contact_frame(Projection::cone, Storage::minimal), 0.25 * kColgate, 1,
         [&](const BoundingStep& s, const Command& rendered) {
           wanted += s.command.elastic.z();
           given += rendered.elastic.z();
         });
  EXPECT_LT(given, 0.8 * wanted);
}

TEST(ElasticStorage, AStiffSpringGetsWhatMinimalStorageGivesIt) {
  // Above the limit every force is at its bound. No stored energy remains, and both methods agree.
  for (const double share : {1.5, 4.0, 40.0}) {
    Bounding minimal(contact_frame(Projection::cone, Storage::minimal)), spare(elastic());
    for (int n = 1; n < 2000; ++n) {
      const double depth = 0.01 * std::sin(std::numbers::pi * n / 2000);
      const double before = 0.01 * std::sin(std::numbers::pi * (n - 1) / 2000);
      BoundingStep s;
      s.displacement.z() = before - depth;
      s.hold_time = kPeriod;
      s.command.elastic.z() = share * kColgate * depth;
      const double a = minimal.step(s).rendered.elastic.z(), b = spare.step(s).rendered.elastic.z();
      ASSERT_NEAR(a, b, 1e-9 * (1.0 + a)) << share << " at " << n;
    }
  }
}

/// Returns the force of a spring four times too stiff at a depth of 1 mm, after `before` ran in the
/// same contact.
template <class Before>
double stiff_force_after(Before before) {
  Bounding bounding(elastic());
  const auto step = [&](double in, double along, const Command& command) {
    return bounding.step({Vec3(along, 0.0, -in), Vec3::Zero(), kPeriod, command}).rendered;
  };
  before(step);
  // The hand presses 1 mm into a spring that commands more than the bound allows.
  Command rendered;
  for (int n = 0; n < 100; ++n)
    rendered = step(1e-5, 0.0, {Vec3(0, 0, 1e6), Vec3::Zero(), Vec3::Zero()});
  return rendered.elastic.z();
}

TEST(ElasticStorage, FrictionFillsNoReservoir) {
  const double fresh = stiff_force_after([](auto) {});
  EXPECT_NEAR(fresh, kColgate * 1e-3, 1e-9);
  const double after = stiff_force_after([](auto step) {
    // A metre of sliding under 2 N of friction dissipates two joules in the frictional channel.
    for (int n = 0; n < 10000; ++n)
      step(0.0, 1e-4, {Vec3(0, 0, 1e-6), Vec3(-2, 0, 0), Vec3::Zero()});
  });
  EXPECT_NEAR(after, fresh, 1e-6);
}

TEST(ElasticStorage, DampingFillsNoReservoir) {
  // The hand trembles 1 mm deep in a soft spring, and the device's damping and a contact damper
  // dissipate energy. The store must still hold only the spring's k d^2 / 2. A suddenly stiff
  // command can get a force of at most sqrt(2 c E).
  constexpr double kStiffness = 0.25 * kColgate, kDepth = 1e-3, kTremble = 1e-5;
  Bounding bounding(elastic());
  const auto step = [&](double in, const Command& command) {
    return bounding.step({Vec3(0, 0, -in), Vec3::Zero(), kPeriod, command}).rendered;
  };
  double depth = 0.0;
  const auto soft = [&](double in) {
    depth += in;
    const double damper = in > 0.0 ? 0.05 : -0.05;
    step(in, {Vec3(0, 0, kStiffness * depth), Vec3(0, 0, damper), Vec3::Zero()});
  };
  while (depth < kDepth - 1e-9) soft(kTremble);
  for (int n = 0; n < 4000; ++n) soft(n % 40 < 20 ? -kTremble : kTremble);
  const Command stiff = step(0.0, {Vec3(0, 0, 1e6), Vec3::Zero(), Vec3::Zero()});
  // The force is slightly smaller, because the damper's force lags the reversals by a sample.
  EXPECT_LE(stiff.elastic.z(), kDepth * std::sqrt(kStiffness * kColgate) + 1e-9);
  EXPECT_GE(stiff.elastic.z(), kStiffness * kDepth);
}

TEST(ElasticStorage, ALostContactEmptiesIt) {
  const double after = stiff_force_after([](auto step) {
    for (int n = 0; n < 100; ++n)  // a soft spring at a depth of 10 mm
      step(1e-4, 0.0, {Vec3(0, 0, 1e-2 * (n + 1)), Vec3::Zero(), Vec3::Zero()});
    step(0.0, 0.0, {});
  });
  EXPECT_NEAR(after, kColgate * 1e-3, 1e-9);
}

TEST(ElasticStorage, AFadedForceKeepsNoMoreThanItsSpringDid) {
  // The device holds half of each command, like a fade. Half of the spring's work must return.
  Bounding bounding(elastic());
  double delivered = 0.0, taken = 0.0, held = 0.0;
  for (int n = 1; n <= 2000; ++n) {
    const double depth = 0.01 * std::sin(std::numbers::pi * n / 2000);
    const double before = 0.01 * std::sin(std::numbers::pi * (n - 1) / 2000);
    const double work = held * (before - depth);
    (work > 0.0 ? delivered : taken) += work;
    BoundingStep s;
    s.displacement.z() = before - depth;
    s.hold_time = kPeriod;
    s.command.elastic.z() = 0.1 * kColgate * depth;
    const Command given = 0.5 * bounding.step(s).rendered;
    bounding.set_held(given);
    held = given.elastic.z();
    ASSERT_NEAR(held, 0.05 * kColgate * depth, 1e-9);
  }
  EXPECT_NEAR(delivered, -taken, 0.01 * delivered);
}

}  // namespace
}  // namespace feltwire::elastic_storage_test
