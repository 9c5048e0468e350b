// Heavy bodies stand on light ones. Tests the loader's warnings and the simulation.
#include "core/dynamics/heavy_loads.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/moving.hpp"

namespace feltwire::heavy_loads_test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kSide = 0.05;  // [m] of both boxes

Scene pile(double heavy, double light, double tick = 1e-3) {
  const Vec3 low(0, 0, 0.5 * kSide), high(0, 0, 1.5 * kSide);
  const Box box{Vec3::Constant(0.5 * kSide)};
  return test::moving({test::object("floor", Plane{}), test::object("lower", box, {}, low),
                       test::object("upper", box, {}, high)},
                      {-1, 0, 1},
                      {test::body("lower", light, low), test::body("upper", heavy, high)},
                      {.tick = tick});
}

std::vector<std::string> sinking(const Scene& scene) {
  std::vector<std::string> found;
  for (const std::string& warning : scene.warnings())
    if (warning.find("may sink into what is below") != std::string::npos) found.push_back(warning);
  return found;
}

/// [m] The way by which the upper box is lower after a second than it began.
double sunk(const Scene& scene) {
  World world(scene);
  for (double time = 0.0; time < 1.0; time += world.tick()) world.step();
  return 1.5 * kSide - world.objects()[2].pose.position.z();
}

TEST(HeavyLoads, AHeavyBodyOnALightOneIsSaidWithNumbersAndRemedy) {
  const Scene scene = pile(1e6, 1.0);
  EXPECT_THAT(
      sinking(scene),
      ElementsAre(AllOf(HasSubstr("'upper' (1e+06 kg) is above 'lower' (1 kg, 50 mm high)"),
                        HasSubstr("by up to 2.45e+03 mm"), HasSubstr("at least 9.8e+02 kg"))));
  EXPECT_GT(sunk(scene), 0.1 * kSide);
}

/// A pile without a warning must stand, for every mass ratio and tick.
TEST(HeavyLoads, APileWithoutAWarningStands) {
  int warned = 0, silent = 0;
  for (const double light : {1e-3, 1.0, 1e3})
    for (const double ratio : {0.01, 1.0, 10.0, 100.0, 1e3, 3e3, 1e4, 1e6})
      for (const double tick : {2e-4, 1e-3, 5e-3}) {
        if (light * ratio > 1e6) continue;
        const Scene scene = pile(light * ratio, light, tick);
        if (!sinking(scene).empty()) {
          ++warned;
          continue;
        }
        ++silent;
        EXPECT_LT(sunk(scene), 0.1 * kSide) << light << " " << ratio << " " << tick;
      }
  EXPECT_GT(warned, 10);
  EXPECT_GT(silent, 30);
}

TEST(HeavyLoads, ALightBodyOnAHeavyOneIsNone) { EXPECT_THAT(sinking(pile(1.0, 1e6)), IsEmpty()); }

TEST(HeavyLoads, WithoutGravityNothingStands) {
  const Vec3 high(0, 0, 0.1);
  const Scene scene = test::moving(
      {test::object("light", Sphere{0.02}), test::object("heavy", Sphere{0.02}, {}, high)}, {0, 1},
      {test::body("light", 1e-3), test::body("heavy", 1e6, high)}, test::kWeightless);
  EXPECT_THAT(sinking(scene), IsEmpty());
}

}  // namespace
}  // namespace feltwire::heavy_loads_test
