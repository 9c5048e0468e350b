#include "sim/studies/bound/frontier_judged.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "core/bounding/device_account.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/bound/frontier_setup.hpp"
#include "sim/studies/bound/over_hands.hpp"

namespace feltwire {
namespace {

constexpr double kJudgedPeriod = 1e-3;   // [s] servo period of the study
constexpr double kPressed = 3.0;         // [N]
constexpr double kWayIn = 0.01;          // [m] way of the hand in the air before it touches
constexpr double kSpeedIn = 0.02;        // [m/s] mean speed of that way
constexpr double kFrictionKnown = 0.75;  // ratio of assumed to true dry friction
constexpr FrontierDevice kPhantomLike = kFrontierDevices[1];

FrontierCase press(const char* law, double damping, double wall, bool cold) {
  FrontierCase c{.task = "press", .law = law, .damping = damping, .device = kPhantomLike};
  c.need = c.law == "shaped" ? Need::inertia_friction : Need::no_account;
  c.wall = wall;
  c.cold = cold;
  return c;
}

/// Draws numbers of hands and plants.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : random_(seed) {}
  double even(double low, double high) {
    return low +
           (high - low) * (static_cast<double>(random_()) / static_cast<double>(random_.max()));
  }
  double log(double low, double high) { return low * std::pow(high / low, even(0.0, 1.0)); }

 private:
  std::mt19937_64 random_;
};

Plant plant_of(const JudgedBar& bar) {
  Plant plant;
  plant.amplifier.lag = bar.lag;
  if (bar.transmission > 0.0)
    plant.transmission = {
        .stiffness = bar.transmission, .damping = 1.0, .handle_mass = bar.shared.device.mass / 3.0};
  return plant;
}

/// Returns a plant within the told lag, and the lag as it is told.
Plant drawn_plant(const JudgedBar& bar, Draws& draws, MotorLag& told) {
  Plant plant = plant_of(bar);
  const double kind = draws.even(0.0, 3.0), share = draws.even(0.2, 0.8);
  const double delayed = kind < 1.0 ? 0.0 : kind < 2.0 ? 1.0 : share;
  plant.amplifier.lag = (1.0 - delayed) * bar.lag;
  plant.amplifier.delay = delayed * bar.lag;
  told = {.time = bar.lag,
          .kind = kind < 1.0   ? LagKind::filter
                  : kind < 2.0 ? LagKind::delay
                               : LagKind::mixed};
  if (bar.transmission > 0.0) {
    plant.transmission.damping = draws.log(0.2, 3.0);
    plant.transmission.handle_mass = draws.even(0.1, 0.5) * bar.shared.device.mass;
  }
  const double friction = bar.shared.device.friction;
  if (draws.even(0.0, 1.0) < 0.5)
    plant.friction = {.breakaway = draws.even(1.0, 2.0) * friction, .stribeck_velocity = 5e-3};
  plant.encoder.noise = draws.even(0.0, 0.05) * bar.shared.device.quantum;
  plant.amplifier.resolution = draws.even(0.0, 8e-3);
  return plant;
}

/// Returns the swing [m] of a case's hand on a wall that is an ideal spring: its motor has no lag,
/// its encoder no steps, nothing limits its force, and only the case's transmission stands between
/// motor and handle. The law is asked 20 times as often.
double swing_on_an_ideal_wall(FrontierCase c, const TaskSource& source) {
  constexpr double kFinePeriod = 5e-5;  // [s]
  constexpr double kAnyForce = 1e3;     // [N]
  Plant plant;
  plant.transmission = c.plant->transmission;
  c.plant = std::make_shared<const Plant>(plant);
  c.law = "midpoint";
  c.need = Need::no_account;
  c.told = {};
  c.device.quantum = 0.0;
  c.device.max_force = kAnyForce;
  const CompareTask task = task_of(c, source);
  ExperimentSetup setup = setup_of(c, task);
  setup.bounding.period = kFinePeriod;
  std::vector<double> distance;
  for (const ExperimentSample& s : run_experiment(task.touch, setup))
    distance.push_back(task.distance(s.position));
  return highpass_rms(distance, 1.0 / kFinePeriod);
}

struct Judged {
  OverHands hands;
  double at_encoder = 0.0;    // median share, of a hand that swings 0
  std::size_t there_too = 0;  // hands that swing here, and on an ideal wall
};

Judged judge(const JudgedBar& bar, std::uint64_t seed, int hands) {
  const auto rows = run_frontier(judged_cases(bar, seed, hands));
  std::vector<double> shares;
  shares.reserve(rows.size());
  for (const FrontierRow& row : rows)
    shares.push_back(row.oscillation < kCalm ? row.displayed_at_encoder : 0.0);
  Judged judged{over_hands(rows, [](const FrontierCase&) { return true; }), median(shares)};
  const TaskSource source;
  for (const FrontierRow& row : rows)
    if (!(row.oscillation < kCalm) && !(swing_on_an_ideal_wall(row.made, source) < kCalm))
      ++judged.there_too;
  return judged;
}

}  // namespace

std::vector<JudgedBar> judged_bars() {
  std::vector<JudgedBar> bars;
  const auto add = [&](std::string name, const FrontierCase& c, double lag, double transmission) {
    bars.push_back({std::move(name), c, lag, transmission});
  };
  for (const bool cold : {true, false}) {
    const FrontierCase wall = press("shaped", 0.005, 5e3, cold);
    for (const double lag : {0.0, 0.3e-3, 0.5e-3}) add("shaped", wall, lag, 0.0);
    for (const double behind : {3.5e3, 7e3, 10e3, 20e3}) add("shaped", wall, 0.5e-3, behind);
  }
  for (const bool cold : {true, false})
    for (const double lag : {0.0, 0.15e-3, 0.3e-3, 0.5e-3})
      add("shaped", press("shaped", 0.005, 40e3, cold), lag, 0.0);
  FrontierCase more = press("shaped", 0.005, 5e3, true);
  more.hand_force = 5.0;
  add("shaped, told a hand of 5 N", more, 0.3e-3, 0.0);
  more.device.quantum = 5e-6;
  add("shaped, 5 N and an encoder of 5 um", more, 0.3e-3, 0.0);
  more.hand_force = kHandForce;
  add("shaped, an encoder of 5 um", more, 0.3e-3, 0.0);
  for (const double damping : {0.5, 2.0})
    for (const double lag : {0.15e-3, 0.3e-3, 0.5e-3})
      for (const double wall : {5e3, 40e3})
        add("contact_frame", press("contact_frame", damping, wall, true), lag, 0.0);
  for (const double behind : {3.5e3, 10e3})
    add("contact_frame", press("contact_frame", 2.0, 5e3, true), 0.3e-3, behind);
  return bars;
}

std::vector<FrontierCase> judged_cases(const JudgedBar& bar, std::uint64_t seed, int hands) {
  std::vector<FrontierCase> cases;
  const auto plain = std::make_shared<const Plant>(plant_of(bar));
  for (const NamedHand& hand : kEightHands) {
    FrontierCase c = bar.shared;
    c.hand = hand;
    c.plant = plain;
    c.told = {.time = bar.lag, .kind = LagKind::filter};
    cases.push_back(c);
  }
  Draws draws(seed);
  for (int n = 0; n < hands; ++n) {
    FrontierCase c = bar.shared;
    c.hand = {.name = "drawn",
              .hand = {.mass = draws.log(0.005, 0.5),
                       .damping = draws.log(0.3, 10.0),
                       .stiffness = draws.log(30.0, 1000.0)}};
    Plant plant = drawn_plant(bar, draws, c.told);
    plant.seed = seed + static_cast<std::uint64_t>(n);
    c.plant = std::make_shared<const Plant>(plant);
    cases.push_back(c);
  }
  return cases;
}

double paid_share(const JudgedBar& bar) {
  const FrontierCase& c = bar.shared;
  DeviceSpec spec = builtin_device("simulated");
  spec.damping = c.damping;
  spec.apparent_mass = spec.least_mass = c.device.mass;
  spec.coulomb_friction = c.device.friction;
  spec.least_friction = kFrictionKnown * c.device.friction;
  spec.position_resolution = c.device.quantum;
  spec.hand_force = c.hand_force;
  spec.actuation.lag = bar.lag;
  spec.actuation.kind = LagKind::filter;
  const double needed =
      need_at_rest(account_config(spec, kJudgedPeriod), {.elastic = Vec3(0.0, kPressed, 0.0)});
  // A path in space is certainly a third of the sum of its axes' ways, times sqrt(3).
  const double way_in = (spec.least_friction / std::numbers::sqrt3 + c.damping * kSpeedIn) * kWayIn;
  // The balance of a hand that rests at the depth F / (s k) is way_in + F^2 / (2 s k).
  const double left = needed - way_in, whole = kPressed * kPressed / (2.0 * c.wall);
  return left > whole ? whole / left : 1.0;
}

std::string judged_table(std::uint64_t seed, int hands) {
  std::string text;
  append(text, "First presses with %.0f N of the eight hands and %d drawn ones (seed %llu) on a ",
         kPressed, hands, static_cast<unsigned long long>(seed));
  text +=
      "device of\n75 g, 0.04 N and 30 um whose lag is told. Median share (a hand that swings "
      "counts as 0) at the encoder\nand at the handle; calm hands (below 10 um at the handle); how "
      "many of the others swing on an ideal\nspring behind the same transmission, too; the worst "
      "swing; the most energy that the true motor made;\nand the share that a cold account can pay "
      "for, or 2b/(T + 2L) over the wall.\n\n";
  append(text, "%-34s %-5s %-6s %-4s %-6s %-6s | %-7s %-7s %-9s %-5s %-8s %-9s %s\n", "law", "b",
         "N/m", "ms", "kN/m", "start", "encoder", "handle", "calm", "ideal", "um", "mJ", "limit");
  for (const JudgedBar& bar : judged_bars()) {
    const Judged found = judge(bar, seed, hands);
    const FrontierCase& c = bar.shared;
    const bool bound = c.law == "contact_frame";
    append(text, "%-34s %-5g %-6g %-4g %-6s %-6s | %7.3f %7.3f %3zu of %-3zu %5zu %8.1f %9.3g ",
           bar.name.c_str(), c.damping, c.wall, kMilli * bar.lag,
           bar.transmission > 0.0 ? std::to_string(bar.transmission * 1e-3).substr(0, 4).c_str()
                                  : "rigid",
           c.cold ? "cold" : "warm", found.at_encoder, found.hands.median, found.hands.calm,
           found.hands.hands, found.there_too, kMicro * found.hands.worst_oscillation,
           kMilli * found.hands.made_at_motor);
    if (bound)
      append(text, "%.3f\n",
             std::min(1.0, 2.0 * c.damping / (kJudgedPeriod + 2.0 * bar.lag) / c.wall));
    else if (c.cold)
      append(text, "%.3f\n", paid_share(bar));
    else
      text += "\n";
  }
  return text;
}

}  // namespace feltwire
