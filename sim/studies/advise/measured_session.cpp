#include "sim/studies/advise/measured_session.hpp"

#include <span>

#include "client/run/rehearsal.hpp"
#include "sim/measure/fidelity.hpp"
#include "sim/measure/network_run.hpp"

namespace feltwire::advise {
namespace {

constexpr double kDuration = 4.0, kAtRest = 0.5;  // [s] of a run, and at its end
constexpr double kSettled = 1.0;                  // [s] a session may lack replies until then

NetworkRunOptions options_of(const DrawnCase& drawn, const Setting& setting, const Place& place) {
  NetworkRunOptions options;
  const DeviceSpec& spec = drawn.device;
  options.parameters = setting.parameters();
  options.link = parse_link(drawn.link);
  options.duration = kDuration;
  options.hand.spec = spec;
  options.hand.hand = drawn.hand;
  options.hand.plant.transmission = assumed_plant_transmission(spec);
  auto& amplifier = options.hand.plant.amplifier;
  (spec.actuation.kind == LagKind::filter ? amplifier.lag : amplifier.delay) = spec.actuation.lag;
  HandTask& task = options.hand.task;
  task.center = place.point;
  set_normal(task, place.normal);
  task.lead_in = drawn.lead_in;
  task.depth = press_force(spec) * (1.0 / drawn.hand.stiffness + 1.0 / place.material.stiffness +
                                    1.0 / options.hand.plant.transmission.stiffness);
  return options;
}

}  // namespace

Measured measured_press(const DrawnCase& drawn, const Setting& setting, const Place& place,
                        bool timed) {
  NetworkRunOptions options = options_of(drawn, setting, place);
  options.timed = timed;
  const NetworkRunResult run = run_network(drawn.scene, options);
  const double period = options.parameters.servo_period;
  Measured found;
  double force = 0.0, depth = 0.0, age = 0.0, ages = 0.0;
  for (const NetworkSample& sample : run.samples) {
    if (sample.time > kDuration - kAtRest) {
      force += sample.held.force().dot(place.normal);
      depth += sample.ideal.elastic.norm() / place.material.stiffness;
    }
    if (sample.time < kSettled || sample.sample_index == 0) continue;
    age += sample.time - static_cast<double>(sample.sample_index - 1) * period;
    ages += 1.0;
  }
  found.felt = depth > 0.0 ? force / depth : 0.0;
  found.news_age = ages > 0.0 ? age / ages : 0.0;
  found.oscillation = oscillation(run.samples, 1.0 / period);
  found.up_kbit = run.up.kbit_per_second(kDuration);
  found.down_kbit = run.down.kbit_per_second(kDuration);
  found.server = seconds(run.server_time) / kDuration;
  found.client = seconds(run.client_time) / kDuration;
  found.passive = run.observed_port.violations() == 0;
  return found;
}

}  // namespace feltwire::advise
