#include "core/bounding/bounding.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace feltwire {
namespace {

// Beyond these nothing is a force or a movement of a hand but a fault upstream; it also keeps every
// product below finite.
constexpr double kAbsurdForce = 1e12;       // [N], [N m]
constexpr double kAbsurdMovement = 1e6;     // [m], [rad]
constexpr double kAbsurdHold = 1e6;         // [s]
constexpr double kAbsurdStiffness = 1e100;  // [N/m], [N m/rad]

template <class Choice, class Names>
Choice named(std::string_view what, std::string_view given, const Names& names) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == given) return static_cast<Choice>(i);
  std::string message =
      "unknown " + std::string(what) + " '" + std::string(given) + "'; choose one of:";
  for (const auto& n : names) message.append(" ").append(n);
  throw std::invalid_argument(message);
}

void require(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

EbaConstants constants(double damping, double period, std::optional<double> c1,
                       std::optional<double> c2, const std::string& suffix) {
  EbaConstants c;
  c.c1 = c1.value_or(damping / period);
  c.c2 = c2.value_or(c.c1);
  require(c.c1 >= 0.0 && c.c1 <= kAbsurdStiffness,
          "c1" + suffix + " must be finite and not negative");
  require(c.c2 >= 0.0 && c.c2 <= kAbsurdStiffness,
          "c2" + suffix + " must be finite and not negative");
  require(c.c2 <= c.c1,
          "c2" + suffix + " = " + std::to_string(c.c2) + " is above c1" + suffix + " = " +
              std::to_string(c.c1) +
              ": the bounding laws would contradict each other; lower c2 or raise c1");
  return c;
}

void check(const BoundingConfig& c) {
  require(std::isfinite(c.period) && c.period > 0.0, "period must be finite and above zero [s]");
  require(std::isfinite(c.damping) && c.damping >= 0.0,
          "damping must be finite and not negative [N s/m]");
  require(std::isfinite(c.rotational_damping) && c.rotational_damping >= 0.0,
          "rotational damping must be finite and not negative [N m s/rad]");
  require(2.0 * c.damping / c.period <= kAbsurdStiffness,
          "damping over period is absurd; the period is too short for this damping");
  require(2.0 * c.rotational_damping / c.period <= kAbsurdStiffness,
          "rotational damping over period is absurd; the period is too short for this damping");
  require(c.max_force > 0.0, "max force must be above zero [N]");
  require(c.max_torque >= 0.0, "max torque must not be negative [N m]");
}

/// False for NaN too: it compares with nothing.
bool sane(const Vec3& v, double limit) {
  return std::abs(v.x()) <= limit && std::abs(v.y()) <= limit && std::abs(v.z()) <= limit;
}

/// The factor that brings `magnitude` under `limit`.
double limit_factor(double magnitude, double limit) {
  return magnitude > limit ? limit / magnitude : 1.0;
}

/// The movement that takes most from a port over `hold_time` while f is held: dx = f h / (2 b)
/// minimises F.dx + (b/h) |dx|^2.
Vec3 worst_movement(const Vec3& held, double hold_time, double damping) {
  return damping > 0.0 ? Vec3(held * (hold_time / (2.0 * damping))) : Vec3::Zero();
}

/// Beyond rounding. Sane vectors: no square overflows.
bool differs(const Vec3& a, const Vec3& b) {
  return (a - b).squaredNorm() > 1e-24 * b.squaredNorm();
}

}  // namespace

std::string_view name(BoundingMode mode) {
  return kBoundingModeNames[static_cast<std::size_t>(mode)];
}
std::string_view name(Projection p) { return kProjectionNames[static_cast<std::size_t>(p)]; }

std::string_view name(Storage s) { return kStorageNames[static_cast<std::size_t>(s)]; }

BoundingMode bounding_mode(std::string_view given) {
  return named<BoundingMode>("bounding mode", given, kBoundingModeNames);
}
Projection projection(std::string_view given) {
  return named<Projection>("projection", given, kProjectionNames);
}
Storage storage(std::string_view given) { return named<Storage>("storage", given, kStorageNames); }

Bounding::Bounding(const BoundingConfig& config) : config_(config) {
  check(config);
  const PerAxisBound axes{
      .translation = constants(config.damping, config.period, config.c1, config.c2, ""),
      .rotation = constants(config.rotational_damping, config.period, config.c1_rotation,
                            config.c2_rotation, " (rotation)"),
      .torque = config.rotation};
  switch (config.mode) {
    case BoundingMode::none:
      method_ = NoBound{};
      break;
    case BoundingMode::total_energy:
      method_ = TotalEnergyBound{.per_axis = axes, .last = {}};
      break;
    case BoundingMode::per_axis:
      method_ = axes;
      break;
    case BoundingMode::per_axis_projected:
      method_ = ProjectedBound{axes};
      break;
    case BoundingMode::contact_frame:
      method_ = ContactFrameBound({2.0 * config.damping / config.period, config.period},
                                  {2.0 * config.rotational_damping / config.period, config.period},
                                  config.projection, config.storage, config.rotation);
      break;
  }
}

Bounded Bounding::step(const BoundingStep& given) noexcept {
  Bounded result;
  BoundingStep s = given;
  if (!config_.rotation) s.command.torque = s.rotation = Vec3::Zero();

  const bool command_sane = sane(s.command.elastic, kAbsurdForce) &&
                            sane(s.command.frictional, kAbsurdForce) &&
                            sane(s.command.torque, kAbsurdForce);
  const bool displacement_sane = sane(s.displacement, kAbsurdMovement);
  const bool rotation_sane = sane(s.rotation, kAbsurdMovement);
  const bool hold_sane = std::abs(s.hold_time) <= kAbsurdHold;
  // A hold shorter than T earns no more credit than T.
  if (!hold_sane || s.hold_time < config_.period) s.hold_time = config_.period;
  if (!command_sane || !displacement_sane || !rotation_sane || !hold_sane) [[unlikely]] {
    result.refused = true;
    s.command = {};
    if (!displacement_sane)
      s.displacement = worst_movement(held_.force(), s.hold_time, config_.damping);
    if (!rotation_sane)
      s.rotation = worst_movement(held_.torque, s.hold_time, config_.rotational_damping);
  }

  result.rendered = std::visit([&](auto& method) { return method.step(s); }, method_);
  // The paper's laws would hold on to a part of the last force; zero is passive too, for the stored
  // energy pays for the worst that the hand did.
  if (result.refused) [[unlikely]]
    result.rendered = {};
  result.active = config_.mode != BoundingMode::none &&
                  (differs(result.rendered.force(), s.command.force()) ||
                   (config_.rotation && differs(result.rendered.torque, s.command.torque)));

  const double force_factor = limit_factor(length(result.rendered.force()), config_.max_force);
  const double torque_factor =
      config_.rotation ? limit_factor(length(result.rendered.torque), config_.max_torque) : 1.0;
  if (force_factor < 1.0 || torque_factor < 1.0) {
    result.saturated = true;
    result.rendered.elastic *= force_factor;
    result.rendered.frictional *= force_factor;
    result.rendered.torque *= torque_factor;
  }
  if (const auto* method = std::get_if<ContactFrameBound>(&method_))
    result.in_debt = method->in_debt();
  set_held(result.rendered);
  return result;
}

void Bounding::set_held(const Command& held) noexcept {
  if (!sane(held.elastic, kAbsurdForce) || !sane(held.frictional, kAbsurdForce) ||
      !sane(held.torque, kAbsurdForce))
    return;
  held_ = held;
  std::visit([&](auto& method) { method.set_held(held); }, method_);
}

}  // namespace feltwire
