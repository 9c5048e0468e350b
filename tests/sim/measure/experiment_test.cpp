#include "sim/measure/experiment.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/scene_file/load_scene.hpp"
#include "sim/studies/bound/figures.hpp"

namespace feltwire::experiment_test {
namespace {

Scene plane(double stiffness, double friction) {
  const std::string k = std::to_string(stiffness), mu = std::to_string(friction);
  return parse_scene(R"({"name": "plane",
    "materials": [{"name": "m", "stiffness": )" +
                         k + R"(, "static_friction": )" + mu + R"(, "dynamic_friction": )" + mu +
                         R"(}],
    "objects": [{"name": "o", "plane": {}, "material": "m",
                 "orientation": [0.7071067811865476, -0.7071067811865476, 0, 0]}]})",
                     "plane.json");
}

double mean_normal_force(const Scene& scene, std::string_view mode, Projection projection) {
  double sum = 0.0;
  int count = 0;
  for (const ExperimentSample& s :
       run_experiment(scene, figure_setup("wall", mode, 2.0, projection))) {
    if (s.time < 3.0) continue;
    sum += s.rendered.force().y();
    ++count;
  }
  return sum / count;
}

TEST(Experiment, ACommandIsAsOldAsTheDelay) {
  constexpr double kStiffness = 1000.0;
  for (const int delay : {0, 1, 37}) {
    ExperimentSetup setup = figure_setup("wall", "contact_frame", 0.5);
    setup.delay = delay;
    const auto samples = run_experiment(plane(kStiffness, 0.0), setup);
    // measured positions; the hand begins 10 mm above, on a whole encoder step
    std::vector<double> y;
    double measured = std::round(0.01 / 23e-6) * 23e-6;
    for (const ExperimentSample& s : samples) y.push_back(measured += s.displacement.y());
    double largest = 0.0;
    for (std::size_t n = 0; n < samples.size(); ++n) {
      const auto d = static_cast<std::size_t>(delay);
      const double wanted = n < d ? 0.0 : kStiffness * std::max(0.0, -y[n - d]);
      ASSERT_NEAR(samples[n].commanded.force().y(), wanted, 1e-6) << delay << " at " << n;
      largest = std::max(largest, wanted);
    }
    EXPECT_GT(largest, 1.0);
  }
}

TEST(Experiment, ADelayIsRoundedUpToWholeSamples) {
  EXPECT_EQ(delay_samples(0.0, 1e-3), 0);
  EXPECT_EQ(delay_samples(1e-3, 1.0 / 500.0), 1);
  EXPECT_EQ(delay_samples(5e-3, 1.0 / 500.0), 3);
  EXPECT_EQ(delay_samples(20e-3, 1e-3), 20);
  EXPECT_EQ(delay_samples(20e-3, 1e-4), 200);
}

TEST(Experiment, EveryRunBeginsWithTheEnvironmentAsItWasGiven) {
  int asked = 0;
  const Environment counting = [&asked, own = 0](const Tool&) mutable {
    asked = ++own;
    return Command{};
  };
  ExperimentSetup setup = figure_setup("wall", "none", 0.5);
  setup.duration = 0.01;
  for (int run = 0; run < 2; ++run) {
    run_experiment(counting, setup);
    EXPECT_EQ(asked, 11) << "one sample each from 0 to the duration";
  }
}

TEST(Experiment, RefusesWhatCannotBeRun) {
  ExperimentSetup setup = figure_setup("wall", "none", 0.5);
  setup.delay = -1;
  EXPECT_THROW(run_experiment(plane(1000.0, 0.0), setup), std::invalid_argument);
  setup.delay = 0;
  setup.duration = 0.0;
  EXPECT_THROW(run_experiment(plane(1000.0, 0.0), setup), std::invalid_argument);
}

// `joint` loses the normal force, so sessions use `cone` (docs/bounding.md, "Measured").
TEST(Experiment, JointLosesTheNormalForceToDryFrictionConeDoesNot) {
  const Scene scene = plane(1000.0, 0.3);
  const double whole = mean_normal_force(scene, "none", Projection::joint);
  EXPECT_GT(mean_normal_force(scene, "contact_frame", Projection::cone), 0.95 * whole);
  EXPECT_LT(mean_normal_force(scene, "contact_frame", Projection::joint), 0.2 * whole);
}

}  // namespace
}  // namespace feltwire::experiment_test
