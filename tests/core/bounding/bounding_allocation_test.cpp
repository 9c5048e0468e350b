// No step of a bound may allocate: all methods, options, kinds of damping and arithmetic types.

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "tests/core/in_arithmetic.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::bounding_allocation_test {
namespace {

using namespace test;

std::vector<BoundingConfig> every_config() {
  Mat3 coupled;
  coupled << 0.5, 0.1, 0.0, 0.1, 0.4, 0.0, 0.0, 0.0, 0.6;
  const Damping dampings[] = {0.5, Vec3(0.5, 0.3, 0.7), coupled};
  std::vector<BoundingConfig> all;
  for (const BoundingMethod& method : built_in_methods<double>())
    for (const Damping& damping : dampings)
      for (const auto projected : kProjectionNames)
        for (const auto stored : kStorageNames)
          for (const auto reference : kPassivityReferenceNames) {
            BoundingConfig c = config(method.name);
            c.damping = damping;
            c.rotational_damping = Damping(Mat3(2e-3 * damping.matrix()));
            c.projection = projection(projected);
            c.storage = storage(stored);
            c.reference = passivity_reference(reference);
            c.max_force = 1.0;
            all.push_back(c);
          }
  return all;
}

template <class Real>
void never_allocates() {
  std::vector<BasicBoundingStep<Real>> steps;
  Random random(41);
  for (int n = 0; n < 10000; ++n) {
    steps.push_back({random.vector(-6, -2).cast<Real>(), random.vector(-4, 0).cast<Real>(),
                     static_cast<Real>(kModePeriod * random.uniform(0, 3)),
                     random_command(random).cast<Real>()});
    if (n % 100 == 0) steps.back().displacement.x() = std::numeric_limits<Real>::quiet_NaN();
  }
  for (const BoundingConfig& c : every_config()) {
    BasicBounding<Real> bounding = bounding_in<Real>(c);
    PortEnergy port(c.damping, c.rotational_damping, kModePeriod);
    const std::size_t before = allocations();
    int n = 0;
    for (const BasicBoundingStep<Real>& s : steps) {
      const BasicCommand<Real> held = bounding.step(s).rendered;
      if (++n % 3 == 0) bounding.set_held(Real(0.5) * held);
      const BasicProbe<Real> probe = bounding.probe(s.displacement, s.rotation);
      port.step(held.template cast<double>(), s.displacement.template cast<double>(),
                probe.rotation.template cast<double>(), static_cast<double>(s.hold_time));
    }
    EXPECT_EQ(allocations(), before) << c.mode;
  }
}

TEST(BoundingAllocation, NothingAllocatesInTenThousandSteps) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  delete new int(1);
  ASSERT_GT(allocations(), 0u);  // The counter must work.
  never_allocates<double>();
  never_allocates<float>();
}

}  // namespace
}  // namespace feltwire::bounding_allocation_test
