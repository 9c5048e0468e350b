#include "sim/studies/bound/torque.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "core/bounding/device_account.hpp"
#include "core/bounding/method.hpp"
#include "sim/hands/amplifier_lag.hpp"
#include "sim/measure/experiment_metrics.hpp"

namespace feltwire {
namespace {

constexpr double kTorquePeriod = 1e-3;  // [s] servo period

struct TorqueLaw {
  const char* name;
  bool account;
  Ports ports;
};
constexpr std::array kLawsEverywhere = {TorqueLaw{"none", false, Ports::one},
                                        TorqueLaw{"per_axis", false, Ports::one},
                                        TorqueLaw{"per_axis_projected", false, Ports::one},
                                        TorqueLaw{"contact_frame", false, Ports::one},
                                        TorqueLaw{"credited", true, Ports::one},
                                        TorqueLaw{"credited", true, Ports::two}};
/// Laws that need the device's pose without delay, so they cannot work over a network.
constexpr std::array kLawsAtHand = {TorqueLaw{"midpoint", true, Ports::one},
                                    TorqueLaw{"midpoint", true, Ports::two}};

void add_laws(std::vector<TorqueCase>& cases, TorqueCase c) {
  const auto add = [&](const auto& laws) {
    for (const TorqueLaw& law : laws) {
      c.law = law.name;
      c.account = law.account;
      c.ports = law.ports;
      cases.push_back(c);
    }
  };
  add(kLawsEverywhere);
  if (c.delay == 0.0) add(kLawsAtHand);
}

/// Returns the task of a case. The tasks with bodies are made only once, because it is slow to
/// parse a scene.
class TorqueSource {
 public:
  TorqueSource() : bodies_(body_tasks()) {}
  TorqueTask of(const TorqueCase& c) const {
    const auto named = [&](const TorqueTask& task) { return task.name == c.task; };
    for (const auto& tasks : {joint_tasks(c.stiffness), bodies_})
      if (const auto found = std::ranges::find_if(tasks, named); found != tasks.end())
        return *found;
    throw std::invalid_argument("torque has no task '" + c.task + "'");
  }

 private:
  std::vector<TorqueTask> bodies_;
};

/// The ratio of rendered to commanded force, or torque, by least squares.
struct Shown {
  double along = 0.0, whole = 0.0;
  void add(const Vec3& rendered, const Vec3& commanded) {
    along += rendered.dot(commanded);
    whole += commanded.squaredNorm();
  }
  double share() const { return whole > 0.0 ? along / whole : 0.0; }
};

TorqueRow run_case(const TorqueCase& c, const TorqueSource& source) {
  const TorqueTask task = source.of(c);
  const SixDofSetup setup = torque_setup(c, task);
  const auto samples = run_six_dof(task.touch, setup);
  TorqueRow row{.made = c, .energy = energy_made(setup.hand.spec, samples, kTorquePeriod)};
  Shown force, torque;
  std::vector<double> directions;
  std::array<std::vector<double>, 3> turns;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const SixDofSample& s = samples[n];
    const Vec3 turn = rotation_between(Quaternion::Identity(), s.pose.orientation);
    for (std::size_t i = 0; i < turns.size(); ++i)
      turns[i].push_back(turn[static_cast<Eigen::Index>(i)]);
    row.excess += s.in_debt ? 1 : 0;
    if (2 * n < samples.size()) continue;
    force.add(s.rendered.force(), s.commanded.force());
    torque.add(s.rendered.torque, s.commanded.torque);
    constexpr double kFeltTurn = 1e-4;  // [N m] no direction error is computed for smaller torques
    if (s.rendered.torque.norm() > kFeltTurn && s.commanded.torque.norm() > kFeltTurn)
      directions.push_back(angle_between(s.rendered.torque, s.commanded.torque));
  }
  row.force_share = force.share();
  row.torque_share = torque.share();
  row.direction_error = spread(std::move(directions)).mean;
  if (c.plant) row.energy.real = samples.back().energy.made;
  for (const auto& turn : turns)
    row.oscillation = std::max(row.oscillation, highpass_rms(turn, 1.0 / kTorquePeriod));
  return row;
}

}  // namespace

DeviceSpec torque_device(double damping) {
  DeviceSpec spec = builtin_device("simulated_6dof");
  spec.rotational_damping = damping;
  return spec;
}

SixDofSetup torque_setup(const TorqueCase& c, const TorqueTask& task) {
  TorqueTask pressed = task;
  const Hand hand = with_wrist(c.hand.hand);
  press(pressed, hand);
  SixDofSetup setup;
  setup.hand = {
      .spec = torque_device(c.damping), .hand = hand, .task = pressed.hand, .wrist = pressed.wrist};
  DeviceSpec& spec = setup.hand.spec;
  spec.actuation.lag = setup.bounding.lag = c.told.time;
  spec.actuation.kind = c.told.kind;
  if (c.plant) setup.hand.plant = *c.plant;
  setup.duration = pressed.duration;
  setup.bounding.mode = bounding_method(c.law).name;
  setup.bounding.projection = Projection::cone;
  setup.bounding.period = kTorquePeriod;
  setup.bounding.damping = spec.damping;
  setup.bounding.rotational_damping = spec.rotational_damping;
  setup.bounding.quantum = spec.position_resolution;
  setup.bounding.max_force = spec.max_force;
  setup.bounding.max_torque = spec.max_torque;
  setup.bounding.rotation = true;
  setup.ports = c.ports;
  setup.delay = static_cast<int>(std::lround(c.delay / kTorquePeriod));
  if (c.account) setup.account = account_config(spec, kTorquePeriod);
  return setup;
}

std::vector<TorqueCase> torque_cases() {
  constexpr std::array kStiffnesses = {8.0, 64.0};  // [N m/rad]; 5 and 40 kN/m at a lever of 40 mm
  constexpr std::array kDelays = {0.0, 0.02};
  std::vector<TorqueCase> cases;
  for (const TorqueTask& task : joint_tasks(0.0))
    for (const double stiffness : kStiffnesses)
      for (const double delay : kDelays)
        for (const NamedHand& hand : kEightHands)
          add_laws(cases,
                   {.task = task.name, .stiffness = stiffness, .delay = delay, .hand = hand});
  for (const TorqueTask& task : body_tasks())
    for (const double delay : kDelays)
      for (const NamedHand& hand : kEightHands)
        add_laws(cases, {.task = task.name, .stiffness = 0.0, .delay = delay, .hand = hand});
  return cases;
}

std::vector<TorqueCase> torque_cases(const Plant& plant, bool told) {
  const auto shared = std::make_shared<const Plant>(for_any_hand(plant));
  std::vector<TorqueCase> cases = torque_cases();
  std::erase_if(cases, [](const TorqueCase& c) { return c.delay > 0.0; });
  for (TorqueCase& c : cases) {
    c.plant = shared;
    if (told) c.told = lag_of(plant.amplifier);
  }
  return cases;
}

std::vector<TorqueRow> run_torque(const std::vector<TorqueCase>& cases) {
  const TorqueSource source;
  std::vector<TorqueRow> rows(cases.size());
  parallel_for(cases.size(), [&](std::size_t i) { rows[i] = run_case(cases[i], source); });
  return rows;
}

bool ports_hold(const std::vector<TorqueRow>& rows, const std::vector<TorqueSession>& sessions) {
  constexpr double kRounding = 1e-12;   // [J] largest energy that rounding may explain
  constexpr double kIntegrated = 1e-9;  // [J] the same of the integrated motion of a plant
  const auto bounded = [](const TorqueCase& c) { return c.account || c.law == kDefaultMethod; };
  return std::ranges::none_of(rows,
                              [&](const TorqueRow& row) {
                                const TorqueCase& c = row.made;
                                if (!c.plant) return bounded(c) && row.energy.measured > kRounding;
                                return c.account && c.told.time > 0.0 &&
                                       row.energy.real > kIntegrated;
                              }) &&
         std::ranges::none_of(sessions, [](const TorqueSession& s) {
           return s.violations > 0 || s.energy_made > kRounding;
         });
}

}  // namespace feltwire
