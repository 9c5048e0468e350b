#include "sim/studies/bound/extremes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "client/hands/simulated_device.hpp"
#include "core/scene/scene.hpp"
#include "sim/studies/bound/bound_in_session.hpp"
#include "sim/studies/bound/in_float.hpp"
#include "sim/studies/bound/stress_inputs.hpp"

namespace feltwire {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kSteps = 1500;            // number of steps of each hand
constexpr int kSceneSteps = 2000;       // largest number of steps at a wall
constexpr double kLongestScene = 20.0;  // [s] longest simulated time at a wall

/// The number of inputs of a step, and the index of the hold time. A step has five vectors of three
/// inputs each, then the hold time. The hold time counts as three inputs, so that it is chosen as
/// often as a vector.
constexpr std::size_t kInputs = 18, kHoldTime = 15;

/// Replaces the given input of the step by NaN, infinity, or an impossible force, movement or time.
template <class Real>
void spoil(StressRandom& random, std::size_t input, BasicBoundingStep<Real>& told) {
  constexpr std::array kStrange = {kNan, kInfinity, -kInfinity, 1e300, -1e300, 1.1e12};
  const Real strange = narrowed<Real>(kStrange[random.below(kStrange.size())]);
  Vector3<Real>* const vectors[] = {&told.displacement, &told.rotation, &told.command.elastic,
                                    &told.command.frictional, &told.command.torque};
  if (input < kHoldTime)
    (*vectors[input / 3])[static_cast<int>(input % 3)] = strange;
  else
    told.hold_time = std::isfinite(strange) ? std::abs(strange) : strange;
}

void judge_force(const Command& rendered, bool refused, double limit, double epsilon,
                 ExtremeOutcome& outcome) {
  const Vec3 force = rendered.force();
  ++outcome.steps;
  outcome.rendering += !force.isZero(0.0);
  outcome.nan += force.hasNaN() || rendered.torque.hasNaN();
  outcome.inf += (force.array().abs() == kInfinity).any() ||
                 (rendered.torque.array().abs() == kInfinity).any();
  outcome.over_limit += force.norm() > limit * (1.0 + 8.0 * epsilon) ||
                        rendered.torque.norm() > 0.01 * limit * (1.0 + 8.0 * epsilon);
  outcome.not_refused += refused && !(force.isZero(0.0) && rendered.torque.isZero(0.0));
}

/// Returns the energy guarantee (Promise) that remains after a refused input. A virtual coupling
/// and a passivity controller then drop or reduce their force, so they no longer guarantee
/// anything.
Promise after_refusal(Promise kept) {
  return kept == Promise::port || kept == Promise::port_by_axis ? kept : Promise::none;
}
bool beyond(const Command& rendered) {
  return (rendered.force().array().abs() > 0.5 * kLargestForce).any() ||
         (rendered.torque.array().abs() > 0.5 * kLargestForce).any();
}

void judge_energy(const PromiseLedger& ledger, ExtremeOutcome& outcome) {
  outcome.broken = outcome.broken || ledger.broken();
  if (ledger.error() <= outcome.energy_error) return;
  outcome.energy_error = ledger.error();
  outcome.rounding = ledger.rounding();
}

BoundingConfig bound_config(std::string_view mode, int variant, const Damping& damping,
                            const Damping& rotational_damping, double period, double max_force,
                            double assumed_damping) {
  BoundingConfig config;
  config.mode = mode;
  config.projection = variant % 2 ? Projection::joint : Projection::cone;
  config.storage = variant / 2 % 2 ? Storage::elastic : Storage::minimal;
  config.period = period;
  const auto told = [&](const Damping& b) {
    return b.isotropic() ? Damping(assumed_damping * b.matrix()(0, 0))
                         : Damping(Mat3(assumed_damping * b.matrix()));
  };
  config.damping = told(damping);
  config.rotational_damping = told(rotational_damping);
  config.max_force = max_force;
  config.max_torque = 0.01 * max_force;
  config.rotation = true;
  return config;
}

template <class Real>
bool keeps_all(const BasicBoundingMethod<Real>& method, const BoundingConfig& config) {
  return method.keeps_all || config.storage == Storage::elastic;
}

/// Returns the energy guarantee of a method as a session runs it. A method that shapes has the
/// account after it, and the account keeps its guarantee in spite of every fault: what a long hold
/// overdraws is a debt, and no force is rendered until it is repaid.
template <class Real>
Promise promise_in_session(const BasicBoundingMethod<Real>& method, const Faults& faults) {
  return method.shapes ? Promise::port : promise(method, faults);
}

/// Computes the work of the scene on the tool of a virtual coupling, and adds it to the ledger. The
/// position of the tool has the precision of Real.
template <class Real>
class ToolBook {
 public:
  explicit ToolBook(const BoundingConfig& config) : config_(config) {}
  void enter(const BoundInSession<Real>& bounding, const BasicBoundingStep<Real>& told,
             PromiseLedger& ledger) {
    const BasicProbe<Real> zero = bounding.probe(Vector3<Real>::Zero(), Vector3<Real>::Zero());
    const auto port = [&](const CouplingConfig& law, const Damping& b, const Vec3& stretch,
                          Vec3& last, const Vec3& moved, const Vec3& force) {
      const Vec3 tool = moved - (stretch - last);
      last = stretch;
      const double stiffness = law.stiffness.value_or(b.least() / config_.period);
      return PromiseLedger::Tool{force.dot(tool),
                                 0.5 * stiffness * stretch.squaredNorm() +
                                     0.5 * law.mass * (tool / config_.period).squaredNorm()};
    };
    const Command command = told.command.template cast<double>();
    ledger.tool_moved(port(config_.coupling, config_.damping, -zero.offset.template cast<double>(),
                           stretch_, told.displacement.template cast<double>(), command.force()),
                      port(config_.coupling_rotation, config_.rotational_damping,
                           -zero.rotation.template cast<double>(), turn_,
                           told.rotation.template cast<double>(), command.torque));
  }

 private:
  BoundingConfig config_;
  Vec3 stretch_ = Vec3::Zero(), turn_ = Vec3::Zero();
};

template <class Real>
void attack(const StressInputs& stress, const BasicBoundingMethod<Real>& method, Promise kept,
            int hand, double assumed_damping, ExtremeOutcome& outcome) {
  StressRandom random(static_cast<std::uint64_t>(hand) + 1);
  const BoundingConfig config =
      bound_config(method.name, hand / 5 + hand, stress.damping, stress.rotational_damping,
                   stress.period, stress.max_force, assumed_damping);
  BoundInSession<Real> bounding(method, config);
  PromiseLedger ledger({kept, stress.damping, stress.rotational_damping, stress.period,
                        keeps_all(method, config), kArithmetic<Real>, method.shapes});
  ToolBook<Real> tool(config);
  using Limits = std::numeric_limits<Real>;
  const double least =
      stress.denormal_moves ? std::log10(double{Limits::denorm_min()}) : stress.least_move;
  const double largest =
      stress.denormal_moves ? std::log10(double{Limits::min()}) : stress.largest_move;

  Vec3 place = Vec3::Constant(stress.origin);
  BasicCommand<Real> held;
  for (int n = 0; n < kSteps; ++n) {
    const bool strange = random.chance(stress.strange_inputs);
    const std::size_t input = random.below(kInputs);
    double hold_time =
        stress.period *
        (random.chance(0.1) ? random.uniform(1.0, stress.longest_hold) : random.uniform(0.2, 1.0));
    if (strange && input >= kHoldTime) hold_time = stress.period * stress.longest_hold;
    StressedMovement m =
        move(hand % 5, random, stress, held.template cast<double>(), hold_time, least, largest);
    if (stress.origin != 0.0) {
      const Vec3 next = place + m.displacement;
      m.displacement = next - place;
      place = next;
    }
    BasicBoundingStep<Real> told{narrowed<Real>(m.displacement), narrowed<Real>(m.rotation),
                                 narrowed<Real>(hold_time),
                                 narrowed<Real>(command(random, stress))};
    const Vec3 moved = told.displacement.template cast<double>();
    const Vec3 turned = told.rotation.template cast<double>();
    ledger.moved(held.template cast<double>(), moved, turned, hold_time);
    if (strange) spoil(random, input, told);

    const BasicBounded<Real> out = bounding.step(told);
    const Command rendered = out.rendered.template cast<double>();
    judge_force(rendered, out.refused, stress.max_force, double{Limits::epsilon()}, outcome);
    if (out.refused || beyond(rendered)) kept = after_refusal(kept);
    if (kept == Promise::coupling) tool.enter(bounding, told, ledger);
    if (kept != Promise::none)
      ledger.rendered(rendered, told.command.template cast<double>(), moved, turned);

    if (random.chance(stress.skipped_writes)) {
      bounding.set_held(held);
    } else {
      held = out.rendered;
      if (random.chance(stress.fades)) {
        held = static_cast<Real>(random.uniform(0.0, 1.0)) * held;
        bounding.set_held(held);
      }
    }
  }
  judge_energy(ledger, outcome);
}

/// A stress test in closed loop: a simulated hand slides over a wall with friction.
struct WallStress {
  double stiffness = 1e3, origin = 0.0, period = 1e-3;
  std::string name() const {
    std::array<char, 64> text;
    std::snprintf(text.data(), text.size(), "wall %g N/m%s%s", stiffness,
                  origin > 0.0 ? "; at 1e6 m" : "",
                  period < 1e-3   ? "; 1 us"
                  : period > 1e-3 ? "; 0.1 s"
                                  : "");
    return text.data();
  }
};

std::vector<WallStress> walls() {
  std::vector<WallStress> all;
  for (const double origin : {0.0, 1e6})
    for (const double stiffness : {1e-3, 1.0, 1e3, 1e6, 1e9}) all.push_back({stiffness, origin});
  for (const double period : {1e-6, 0.1}) all.push_back({1e9, 0.0, period});
  return all;
}

/// Returns the force limit [N]. It is infinite for methods that guarantee nothing under a force
/// limit: virtual couplings and passivity controllers.
template <class Real>
double wall_limit(const BasicBoundingMethod<Real>& method) {
  const Faults limited{.reductions = true};
  return promise(method, limited) == promise(method, {}) ? 8.9 : kInfinity;
}

template <class Real>
void touch_wall(const WallStress& stress, const BasicBoundingMethod<Real>& method, Promise kept,
                int hand, double assumed_damping, ExtremeOutcome& outcome) {
  const Vec3 place = Vec3::Constant(stress.origin);
  const Object wall{.name = "wall",
                    .shape = Plane{},
                    .pose = {place, Quaternion::Identity()},
                    .material = {.stiffness = stress.stiffness,
                                 .damping = 1.0,
                                 .static_friction = 0.5,
                                 .dynamic_friction = 0.4,
                                 .viscous_friction = 0.5}};
  const Scene scene("extremes", {wall});
  TouchMemory memory = scene.memory();

  SimulatedHandOptions options;
  options.spec = builtin_device("simulated");
  // The force limit of the device acts only if the bounding method has no force limit.
  options.spec.max_force = 1e4;
  options.task = {.path = HandPath::slide,
                  .center = place,
                  .frequency = 0.5e-3 / stress.period,
                  .clearance = 1e-4,
                  .lead_in = 50.0 * stress.period};
  SimulatedDevice device(options);
  const double max_force = wall_limit(method);
  const BoundingConfig config = bound_config(method.name, hand, options.spec.damping, 2e-4,
                                             stress.period, max_force, assumed_damping);
  BoundInSession<Real> bounding(method, config);
  PromiseLedger ledger({kept, options.spec.damping, 2e-4, stress.period, keeps_all(method, config),
                        kArithmetic<Real>, method.shapes});
  ToolBook<Real> tool(config);

  const auto read = [&](int n) {
    return device.read(Nanoseconds(std::llround(n * stress.period * 1e9))).pose.position;
  };
  Vec3 last = read(0), offset_before = Vec3::Zero();
  BasicCommand<Real> held;
  const int steps = std::min(kSceneSteps, static_cast<int>(kLongestScene / stress.period));
  for (int n = 1; n <= steps; ++n) {
    const Vec3 position = read(n);
    BasicBoundingStep<Real> told;
    told.displacement = narrowed<Real>(Vec3(position - last));
    told.hold_time = static_cast<Real>(stress.period);
    last = position;
    const Vec3 moved = told.displacement.template cast<double>();
    ledger.moved(held.template cast<double>(), moved, Vec3::Zero(), stress.period);

    const Vec3 offset =
        bounding.probe(told.displacement, told.rotation).offset.template cast<double>();
    const Vec3 velocity = (moved + offset - offset_before) / stress.period;
    offset_before = offset;
    told.command = narrowed<Real>(scene.touch({position + offset, velocity}, memory));
    const BasicBounded<Real> out = bounding.step(told);
    const Command rendered = out.rendered.template cast<double>();
    judge_force(rendered, out.refused, max_force, kArithmetic<Real>.epsilon, outcome);
    if (out.refused || beyond(rendered)) kept = after_refusal(kept);
    if (kept == Promise::coupling) tool.enter(bounding, told, ledger);
    if (kept != Promise::none)
      ledger.rendered(rendered, told.command.template cast<double>(), moved, Vec3::Zero());
    held = out.rendered;
    device.write(rendered);
  }
  judge_energy(ledger, outcome);
}

}  // namespace

std::vector<ExtremeRow> run_extremes(double assumed_damping, int hands,
                                     const std::vector<std::string_view>& methods) {
  if (!(assumed_damping > 0.0) || !std::isfinite(assumed_damping))
    throw std::invalid_argument(
        "the damping told must be finite and above zero times the real one");
  if (hands < 1) throw std::invalid_argument("each stress needs one hand or more");
  if (methods.empty()) throw std::invalid_argument("there must be one method or more");
  std::vector<ExtremeRow> rows;
  const auto row = [&](std::string stress, std::string_view name, const Faults& faults, int count,
                       const auto& run) {
    const BoundingMethod& method = bounding_method(name);
    const BasicBoundingMethod<float>* in_float = method_in_float(name);
    ExtremeRow r{std::move(stress), method.name, promise_in_session(method, faults), {}, {}};
    for (int hand = 0; hand < count; ++hand) {
      run(method, r.promise, hand, r.in_double);
      if (in_float != nullptr) run(*in_float, r.promise, hand, r.in_float);
    }
    rows.push_back(std::move(r));
  };
  for (const StressInputs& stress : all_stress_inputs())
    for (const std::string_view name : methods)
      row(stress.name, name, stress.faults(), hands,
          [&](const auto& method, Promise p, int hand, ExtremeOutcome& o) {
            attack(stress, method, p, hand, assumed_damping, o);
          });
  for (const WallStress& stress : walls())
    for (const std::string_view name : methods) {
      // bound_config() makes four variants: two projections times two energy storages.
      const int variants = bounding_method(name).projects ? 4 : 1;
      row(stress.name(), name, {}, variants,
          [&](const auto& method, Promise p, int hand, ExtremeOutcome& o) {
            touch_wall(stress, method, p, hand, assumed_damping, o);
          });
    }
  return rows;
}

bool all_passed(const std::vector<ExtremeRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const ExtremeRow& r) { return r.passed(); });
}

}  // namespace feltwire
