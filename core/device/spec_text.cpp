#include "core/device/spec_text.hpp"

#include <functional>
#include <iomanip>
#include <sstream>
#include <string_view>

namespace feltwire {
namespace {

constexpr std::string_view kAssumption = "assumption", kAssumedFor = "assumption for ";

struct Number {
  const char* field;
  const char* unit;
  // True if the energy account relies on this number (too large a value then creates energy), or
  // the share of a wall that the hand feels.
  bool counted_on;
  std::function<std::string(const DeviceSpec&)> text;
};

std::string short_text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string listed(const Vec3& v) {
  return short_text(v.x()) + ", " + short_text(v.y()) + ", " + short_text(v.z());
}

std::string damping_text(const Damping& damping) {
  const Mat3& m = damping.matrix();
  if (damping.isotropic()) return short_text(m(0, 0));
  if (damping.kind() == Damping::Kind::axes) return listed(m.diagonal());
  return listed(m.row(0)) + "; " + listed(m.row(1)) + "; " + listed(m.row(2));
}

template <class Value>
std::function<std::string(const DeviceSpec&)> number(Value DeviceSpec::*member) {
  return [member](const DeviceSpec& spec) { return short_text(static_cast<double>(spec.*member)); };
}

template <class Group, class Value>
std::function<std::string(const DeviceSpec&)> number(Group DeviceSpec::*group,
                                                     Value Group::*member) {
  return [group, member](const DeviceSpec& spec) {
    return short_text(static_cast<double>(spec.*group.*member));
  };
}

const std::vector<Number>& numbers() {
  static const std::vector<Number> list = {
      {"translation_dof", "", false, number(&DeviceSpec::translation_dof)},
      {"rotation_sensed", "", false, number(&DeviceSpec::rotation_sensed)},
      {"rotation_actuated", "", false, number(&DeviceSpec::rotation_actuated)},
      {"damping", "N s/m", true, [](const DeviceSpec& s) { return damping_text(s.damping); }},
      {"rotational_damping", "N m s/rad", true,
       [](const DeviceSpec& s) { return damping_text(s.rotational_damping); }},
      {"apparent_mass", "kg", false, number(&DeviceSpec::apparent_mass)},
      {"least_mass", "kg", true, number(&DeviceSpec::least_mass)},
      {"coulomb_friction", "N", false, number(&DeviceSpec::coulomb_friction)},
      {"least_friction", "N", true, number(&DeviceSpec::least_friction)},
      {"position_resolution", "m", false, number(&DeviceSpec::position_resolution)},
      {"max_force", "N", false, number(&DeviceSpec::max_force)},
      {"continuous_force", "N", false, number(&DeviceSpec::continuous_force)},
      {"max_torque", "N m", false, number(&DeviceSpec::max_torque)},
      {"workspace", "m", false, [](const DeviceSpec& s) { return listed(s.workspace); }},
      {"hand_force", "N", false, number(&DeviceSpec::hand_force)},
      {"hand_speed", "m/s", false, number(&DeviceSpec::hand_speed)},
      {"late_ticks", "", false, number(&DeviceSpec::actuation, &ActuationSpec::late_ticks)},
      {"actuation_lag", "s", true, number(&DeviceSpec::actuation, &ActuationSpec::lag)},
      {"actuation_kind", "", false,
       [](const DeviceSpec& s) {
         return s.actuation.lag > 0.0
                    ? std::string(kLagKindNames[static_cast<std::size_t>(s.actuation.kind)])
                    : std::string("0");
       }},
      {"transmission_stiffness", "N/m", true,
       number(&DeviceSpec::transmission, &TransmissionSpec::stiffness)},
      {"encoder_side", "", false,
       [](const DeviceSpec& s) {
         const bool told =
             s.transmission.stiffness > 0.0 || s.transmission.encoder_side == EncoderSide::handle;
         return told ? std::string(
                           kEncoderSideNames[static_cast<std::size_t>(s.transmission.encoder_side)])
                     : std::string("0");
       }},
      {"rotational_resolution", "rad", false,
       number(&DeviceSpec::rotation, &RotationSpec::resolution)},
      {"least_inertia", "kg m^2", true,
       number(&DeviceSpec::rotation, &RotationSpec::least_inertia)},
      {"hand_torque", "N m", false, number(&DeviceSpec::rotation, &RotationSpec::hand_torque)},
      {"apparent_inertia", "kg m^2", false, number(&DeviceSpec::rotation, &RotationSpec::inertia)},
      {"rotational_friction", "N m", false, number(&DeviceSpec::rotation, &RotationSpec::friction)},
  };
  return list;
}

/// Returns the source of a field, or an empty text if there is none.
std::string_view source_of(const SourcedSpec& described, std::string_view field) {
  const auto found = described.sources.find(field);
  return found == described.sources.end() ? std::string_view() : std::string_view(found->second);
}

}  // namespace

std::string spec_table(const SourcedSpec& described) {
  constexpr int kField = 23, kValue = 19, kUnit = 10;
  std::ostringstream text;
  text << described.spec.name << "\n" << std::left;
  for (const Number& number : numbers()) {
    const std::string value = number.text(described.spec);
    const std::string_view source = source_of(described, number.field);
    if (source.empty() && value == "0") continue;
    text << "  " << std::setw(kField) << number.field << std::setw(kValue) << value << " "
         << std::setw(kUnit) << number.unit << (source.empty() ? "no source told" : source) << "\n";
  }
  return text.str();
}

std::vector<std::string> assumptions(const SourcedSpec& described) {
  std::vector<std::string> said;
  for (const Number& number : numbers()) {
    const std::string_view source = source_of(described, number.field);
    if (!number.counted_on || !source.starts_with(kAssumption)) continue;
    // A source such as "assumption for USB" names the case in which the assumption holds.
    const bool says_for = source.starts_with(kAssumedFor);
    said.push_back(std::string(number.field) + " " + number.text(described.spec) + " " +
                   number.unit + " is an " + std::string(says_for ? source : kAssumption) + "; " +
                   (says_for ? "give yours as " + std::string(number.field) + " in a device file"
                             : std::string("measure yours with feltwire-client identify")));
  }
  if (described.spec.transmission.encoder_side == EncoderSide::handle)
    said.push_back(
        "the encoder is at the handle; the energy bounds hold for an encoder at the motor, so the "
        "motor may give energy that no account sees");
  return said;
}

}  // namespace feltwire
