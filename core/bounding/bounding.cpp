#include "core/bounding/bounding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "core/base/choice.hpp"

namespace feltwire {
namespace {

// Beyond these nothing is a force or a movement of a hand but a fault upstream; it also keeps every
// product below finite, in float too.
constexpr double kLargestMovement = 1e6;    // [m], [rad]
constexpr double kLargestHold = 1e6;        // [s]
constexpr double kLargestStiffness = 1e18;  // [N/m], [N m/rad]
constexpr double kShortestPeriod = 1e-12;   // [s]

void require(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

EbaConstants axis_constants(double damping, double period, std::optional<double> c1,
                            std::optional<double> c2, const std::string& suffix) {
  EbaConstants c;
  c.c1 = c1.value_or(damping / period);
  c.c2 = c2.value_or(c.c1);
  require(c.c1 >= 0.0 && c.c1 <= kLargestStiffness,
          "c1" + suffix + " must be finite and not negative");
  require(c.c2 >= 0.0 && c.c2 <= kLargestStiffness,
          "c2" + suffix + " must be finite and not negative");
  require(c.c2 <= c.c1,
          "c2" + suffix + " = " + std::to_string(c.c2) + " is above c1" + suffix + " = " +
              std::to_string(c.c1) +
              ": the bounding laws would contradict each other; lower c2 or raise c1");
  return c;
}

template <class Real>
EbaAxes<Real> constants(const Damping& damping, double period, std::optional<double> c1,
                        std::optional<double> c2, const std::string& suffix) {
  const Vec3 b = damping.per_axis();
  EbaAxes<Real> axes;
  for (int i = 0; i < 3; ++i) {
    const EbaConstants c = axis_constants(b[i], period, c1, c2, suffix);
    axes.axis[static_cast<std::size_t>(i)] = {static_cast<Real>(c.c1), static_cast<Real>(c.c2)};
  }
  return axes;
}

std::string number(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

template <class Real>
Coupling<Real> coupling(const CouplingConfig& c, double b, double period,
                        const std::string& suffix) {
  const double stiffness = c.stiffness.value_or(b / period);
  require(stiffness >= 0.0 && stiffness <= kLargestStiffness,
          "coupling stiffness" + suffix + " must be finite and not negative");
  const double damping = c.damping.value_or(std::max(0.0, b - 0.5 * stiffness * period));
  require(damping >= 0.0 && std::isfinite(damping),
          "coupling damping" + suffix + " must be finite and not negative");
  require(c.mass > 0.0 && std::isfinite(c.mass),
          "the tool's mass" + suffix + " must be finite and above zero");
  // Colgate's condition, with room for the rounding of its own default.
  const double needed = 0.5 * stiffness * period + damping;
  require(needed <= b * (1.0 + 1e-12),
          "the virtual coupling" + suffix + " is not passive: k T / 2 + b_c = " + number(needed) +
              " is above the device's damping " + number(b) +
              "; lower its stiffness or its damping, or raise the servo rate");
  return {static_cast<Real>(stiffness), static_cast<Real>(damping), static_cast<Real>(c.mass)};
}

void check(const BoundingConfig& c) {
  require(std::isfinite(c.period) && c.period > 0.0, "period must be finite and above zero [s]");
  require(c.period >= kShortestPeriod, "period is too short; give seconds");
  validate(c.damping, "damping");
  validate(c.rotational_damping, "rotational damping");
  require(2.0 * c.damping.matrix().cwiseAbs().maxCoeff() / c.period <= kLargestStiffness,
          "damping over period is absurd; the period is too short for this damping");
  require(2.0 * c.rotational_damping.matrix().cwiseAbs().maxCoeff() / c.period <= kLargestStiffness,
          "rotational damping over period is absurd; the period is too short for this damping");
  if (c.mode == BoundingMode::contact_frame || c.mode == BoundingMode::energy_tank) {
    const std::string remedy = std::string(" must be above zero along every axis for the mode ") +
                               std::string(name(c.mode)) +
                               "; give an axis that hardly has any a small one";
    require(Metric<double>::usable(c.damping), "damping" + remedy);
    require(!c.rotation || Metric<double>::usable(c.rotational_damping),
            "rotational damping" + remedy);
  }
  require(c.max_force > 0.0, "max force must be above zero [N]");
  require(c.max_torque >= 0.0, "max torque must not be negative [N m]");
}

/// False for NaN too: it compares with nothing.
template <class Real>
bool sane(const Vector3<Real>& v, double limit) {
  return std::abs(v.x()) <= limit && std::abs(v.y()) <= limit && std::abs(v.z()) <= limit;
}
template <class Real>
bool sane(const BasicCommand<Real>& c) {
  return sane(c.elastic, kLargestForce) && sane(c.frictional, kLargestForce) &&
         sane(c.torque, kLargestForce);
}

/// Beyond rounding. Sane vectors: no square overflows.
template <class Real>
bool differs(const Vector3<Real>& a, const Vector3<Real>& b) {
  constexpr Real kRounding = 256 * std::numeric_limits<Real>::epsilon();
  return (a - b).squaredNorm() > kRounding * kRounding * b.squaredNorm();
}

/// Squares are enough to see that nothing is to be done. Returns the factor.
template <class Real>
Real limit_factor(const Vector3<Real>& v, Real limit) {
  return v.squaredNorm() <= limit * limit ? Real(1) : reduction(limit, length(v));
}

}  // namespace

std::string_view name(BoundingMode mode) { return name_among(kBoundingModeNames, mode); }
std::string_view name(Projection p) { return name_among(kProjectionNames, p); }
std::string_view name(Storage s) { return name_among(kStorageNames, s); }
std::string_view name(PassivityReference r) { return name_among(kPassivityReferenceNames, r); }

BoundingMode bounding_mode(std::string_view given) {
  return chosen_value<BoundingMode>("bounding mode", given, kBoundingModeNames);
}
Projection projection(std::string_view given) {
  return chosen_value<Projection>("projection", given, kProjectionNames);
}
Storage storage(std::string_view given) {
  return chosen_value<Storage>("storage", given, kStorageNames);
}
PassivityReference passivity_reference(std::string_view given) {
  return chosen_value<PassivityReference>("passivity reference", given, kPassivityReferenceNames);
}

bool moves_probe(BoundingMode mode) {
  return mode == BoundingMode::virtual_coupling || mode == BoundingMode::passivity_control_parallel;
}

bool admits_reduction(BoundingMode mode) noexcept {
  switch (mode) {
    case BoundingMode::none:
    case BoundingMode::contact_frame:
    case BoundingMode::energy_tank:
      return true;
    case BoundingMode::total_energy:  // these bound a force from below too
    case BoundingMode::per_axis:
    case BoundingMode::per_axis_projected:
    case BoundingMode::virtual_coupling:  // a damper that is held back dissipates less
    case BoundingMode::passivity_control:
    case BoundingMode::passivity_control_parallel:
    case BoundingMode::passivity_control_directional:
      return false;
  }
  return false;
}

template <class Real>
BasicBounding<Real>::BasicBounding(const BoundingConfig& config)
    : config_((check(config), config)),
      period_(static_cast<Real>(config.period)),
      max_force_(static_cast<Real>(config.max_force)),
      max_torque_(static_cast<Real>(config.max_torque)),
      rotation_(config.rotation),
      translation_damping_(config.damping),
      rotational_damping_(config.rotational_damping) {
  const PerAxisBound<Real> axes{
      .translation = constants<Real>(config.damping, config.period, config.c1, config.c2, ""),
      .rotation = constants<Real>(config.rotational_damping, config.period, config.c1_rotation,
                                  config.c2_rotation, " (rotation)"),
      .torque = config.rotation};
  const PassivityPort<Real> force_port{config.reference, max_force_,
                                       static_cast<Real>(config.damping.least() / config.period)};
  const PassivityPort<Real> torque_port{
      config.reference, max_torque_,
      static_cast<Real>(config.rotational_damping.least() / config.period)};
  switch (config.mode) {
    case BoundingMode::none:
      method_ = NoBound<Real>{};
      break;
    case BoundingMode::total_energy:
      method_ = TotalEnergyBound<Real>{.axes = axes};
      break;
    case BoundingMode::per_axis:
      method_ = axes;
      break;
    case BoundingMode::per_axis_projected:
      method_ = ProjectedBound<Real>{axes};
      break;
    case BoundingMode::contact_frame:
      method_ = ContactFrameBound<Real>(translation_damping_, rotational_damping_, period_,
                                        config.projection, config.storage, config.rotation);
      break;
    case BoundingMode::virtual_coupling:
      method_ = VirtualCoupling<Real>(
          coupling<Real>(config.coupling, config.damping.least(), config.period, ""),
          coupling<Real>(config.coupling_rotation, config.rotational_damping.least(), config.period,
                         " (rotation)"),
          config.rotation);
      break;
    case BoundingMode::passivity_control:
      method_ = PassivityControl<Real>(force_port, torque_port, config.rotation);
      break;
    case BoundingMode::passivity_control_parallel:
      method_ = PassivityControlParallel<Real>(force_port, torque_port, config.rotation);
      break;
    case BoundingMode::passivity_control_directional:
      method_ = PassivityControlDirectional<Real>(force_port, torque_port, config.rotation);
      break;
    case BoundingMode::energy_tank:
      method_ = EnergyTankBound<Real>(translation_damping_, rotational_damping_, period_,
                                      config.rotation);
      break;
  }
}

/// The step with everything in it usable: what was not is replaced by the worst that it can have
/// been.
template <class Real>
BasicBoundingStep<Real> BasicBounding<Real>::checked(const Step& given,
                                                     bool& refused) const noexcept {
  Step s = given;
  if (!rotation_) s.command.torque = s.rotation = Vector3<Real>::Zero();
  const bool displacement_sane = sane(s.displacement, kLargestMovement);
  const bool rotation_sane = sane(s.rotation, kLargestMovement);
  const bool hold_sane = std::abs(s.hold_time) <= kLargestHold;
  // A hold shorter than T earns no more credit than T.
  if (!hold_sane || s.hold_time < period_) s.hold_time = period_;
  refused = !sane(s.command) || !displacement_sane || !rotation_sane || !hold_sane;
  if (!refused) [[likely]]
    return s;
  s.command = {};
  if (!displacement_sane)
    s.displacement = translation_damping_.worst_movement(held_.force(), s.hold_time);
  if (!rotation_sane) s.rotation = rotational_damping_.worst_movement(held_.torque, s.hold_time);
  // The time of the movement is not known: it is credited nothing.
  if (!hold_sane) s.hold_time = static_cast<Real>(kLargestHold);
  return s;
}

template <class Real>
bool BasicBounding<Real>::saturate(BasicCommand<Real>& rendered) const noexcept {
  const Real force_factor = limit_factor<Real>(rendered.force(), max_force_);
  const Real torque_factor = rotation_ ? limit_factor(rendered.torque, max_torque_) : Real(1);
  if (force_factor == 1 && torque_factor == 1) return false;
  rendered.elastic *= force_factor;
  rendered.frictional *= force_factor;
  rendered.torque *= torque_factor;
  return true;
}

template <class Real>
BasicBounded<Real> BasicBounding<Real>::step(const Step& given) noexcept {
  BasicBounded<Real> result;
  const Step s = checked(given, result.refused);
  result.rendered = std::visit([&](auto& method) { return method.step(s); }, method_);
  // The paper's laws would hold on to a part of the last force; zero is passive too, for the stored
  // energy pays for the worst that the hand did.
  if (result.refused) [[unlikely]]
    result.rendered = {};
  result.active = config_.mode != BoundingMode::none &&
                  (differs<Real>(result.rendered.force(), s.command.force()) ||
                   (rotation_ && differs(result.rendered.torque, s.command.torque)));
  result.saturated = saturate(result.rendered);
  if (const auto* frame = std::get_if<ContactFrameBound<Real>>(&method_))
    result.in_debt = frame->in_debt();
  else if (const auto* tank = std::get_if<EnergyTankBound<Real>>(&method_))
    result.in_debt = tank->in_debt();
  held_ = result.rendered;
  if (result.refused || result.saturated)
    std::visit([&](auto& method) { method.set_held(held_); }, method_);
  return result;
}

template <class Real>
void BasicBounding<Real>::set_held(const BasicCommand<Real>& held) noexcept {
  if (held == held_ || !sane(held)) return;
  held_ = held;
  std::visit([&](auto& method) { method.set_held(held); }, method_);
}

template <class Real>
void BasicBounding<Real>::endow(Real energy) noexcept {
  auto* frame = std::get_if<ContactFrameBound<Real>>(&method_);
  if (frame != nullptr && energy > 0 && std::isfinite(energy)) frame->endow(energy);
}

template <class Real>
BasicProbe<Real> BasicBounding<Real>::probe(const Vector3<Real>& displacement,
                                            const Vector3<Real>& rotation) const noexcept {
  if (const auto* coupling = std::get_if<VirtualCoupling<Real>>(&method_))
    return coupling->probe(displacement, rotation);
  if (const auto* parallel = std::get_if<PassivityControlParallel<Real>>(&method_))
    return parallel->probe();
  return {};
}

template class BasicBounding<double>;
template class BasicBounding<float>;

}  // namespace feltwire
