#include "sim/measure/experiment.hpp"

#include <cmath>
#include <stdexcept>

#include "core/bounding/velocity.hpp"

namespace feltwire {

Environment environment(const Scene& scene) {
  return [&scene, memory = scene.memory()](const Tool& tool) mutable {
    return scene.touch(tool, memory);
  };
}

Bounding bounding_of(const ExperimentSetup& setup) {
  return setup.law == nullptr ? Bounding(setup.bounding) : Bounding(*setup.law, setup.bounding);
}

int delay_samples(double delay, double period) {
  // The small term compensates rounding errors: 20 ms at 1 kHz must be exactly 20 samples.
  return static_cast<int>(std::ceil(delay / period - 1e-9));
}

std::vector<ExperimentSample> run_experiment(const Scene& scene, const ExperimentSetup& setup) {
  return run_experiment(environment(scene), setup);
}

std::vector<ExperimentSample> run_experiment(const Environment& environment,
                                             const ExperimentSetup& setup) {
  const Environment touch = environment;  // a copy with its own state
  const double period = setup.bounding.period;
  Bounding bounding = bounding_of(setup);
  std::optional<PortAccount> account;
  if (setup.account) account.emplace(*setup.account);
  if (!(setup.duration > period) || !std::isfinite(setup.duration))
    throw std::invalid_argument("the duration must be finite and longer than one period [s]");

  if (setup.delay < 0) throw std::invalid_argument("the delay must not be negative [T]");

  SimulatedDevice device(setup.hand);
  VelocityEstimate velocity(setup.velocity_cutoff);
  const auto count = static_cast<std::size_t>(std::floor(setup.duration / period + 0.5)) + 1;
  std::vector<ExperimentSample> samples;
  samples.reserve(count);

  // Commands in transit: the command of a sample arrives `delay` samples later.
  struct Answer {
    Command command;
    ContactNormals walls;
  };
  std::vector<Answer> under_way(static_cast<std::size_t>(setup.delay) + 1);
  Vec3 last_position = device.read(Nanoseconds{0}).pose.position;
  Vec3 last_offset = Vec3::Zero();
  Command held;
  for (std::size_t n = 0; n < count; ++n) {
    ExperimentSample s;
    s.time = static_cast<double>(n) * period;
    const Vec3 measured = device.read(Nanoseconds(std::llround(s.time * 1e9))).pose.position;
    s.position = device.true_position();
    s.motor = device.motor_position();
    s.energy = device.true_energy();
    s.displacement = measured - last_position;
    s.held = held.force();
    last_position = measured;

    // The bounding method chooses the position at which the environment computes the force.
    const Vec3 offset = bounding.probe(s.displacement, Vec3::Zero()).offset;
    const Tool tool{measured + offset,
                    velocity.update(s.displacement + offset - last_offset, period)};
    last_offset = offset;
    Answer& asked = under_way[n % under_way.size()];
    asked.command = actuated(device.spec(), touch(tool));
    if (setup.walls) asked.walls = setup.walls(tool.position);
    const Answer& arrived = under_way[(n + 1) % under_way.size()];
    s.commanded = arrived.command;
    BoundingStep step{.displacement = s.displacement,
                      .rotation = Vec3::Zero(),
                      .hold_time = period,
                      .command = s.commanded,
                      .local = setup.delay == 0,
                      .normals = &arrived.walls};
    s.rendered = step.command = bounding.step(step).rendered;
    if (account) {
      s.rendered = account->step(step);
      s.in_debt = account->in_debt();
    }
    held = device.write(s.rendered);
    bounding.set_held(held);
    if (account) account->set_held(held);
    s.rendered = held;
    samples.push_back(s);
  }
  return samples;
}

}  // namespace feltwire
