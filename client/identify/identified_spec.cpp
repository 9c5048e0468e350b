#include "client/identify/identified_spec.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>
#include <utility>

namespace feltwire {
namespace {

std::string listed(const Vec3& v, int dof) {
  std::ostringstream text;
  for (int i = 0; i < dof; ++i) text << (i > 0 ? ", " : "") << v[i];
  return text.str();
}

nlohmann::ordered_json numbers(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::ordered_json numbers(const Damping& damping) {
  const Mat3& m = damping.matrix();
  if (damping.isotropic()) return nlohmann::ordered_json::array({m(0, 0)});
  if (damping.kind() == Damping::Kind::axes) return numbers(Vec3(m.diagonal()));
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) all.push_back(m(i, j));
  return all;
}

/// Returns the kind and size of the lag for the specification. A lag of up to 1 ms is a mix of
/// delay and first-order lag. A longer lag counts as a delay, because the energy account cannot
/// handle a longer first-order lag.
std::pair<LagKind, double> told_lag(double bound) {
  // [s] Longest mixed lag, and time that is added to a longer lag.
  constexpr double kLongestMixed = 1e-3, kTail = 0.5e-3;
  if (bound <= kLongestMixed) return {LagKind::mixed, bound};
  return {LagKind::delay, bound + kTail};
}

/// Writes the transmission, and what the fit assumes.
void tell_transmission(SourcedSpec& known, const TransmissionFit& fit, const std::string& by) {
  known.spec.transmission.stiffness = fit.stiffness_bound;
  known.spec.transmission.encoder_side = fit.side;
  known.tells_transmission = true;
  std::ostringstream text;
  text << ": lower bound; first resonance at " << fit.resonance << " Hz";
  if (fit.side == EncoderSide::motor)
    text << ", estimate " << fit.stiffness << " N/m, " << fit.handle_mass << " kg behind it";
  else
    text << "; a tenth of the mass on either side of it is assumed";
  known.sources["transmission_stiffness"] = by + text.str();
  known.sources["encoder_side"] = by;
}

}  // namespace

SourcedSpec reported_spec(SourcedSpec requested, const DeviceSpec& reported) {
  constexpr const char* kOfTheDriver = "assumption of the driver";
  if (requested.spec.name != reported.name) {
    const auto all = sourced_builtin_devices();
    const auto found = std::ranges::find(
        all, reported.name, [](const SourcedSpec& one) { return std::string_view(one.spec.name); });
    if (found == all.end()) return {.spec = reported, .sources = {}};
    requested = *found;
  }
  if (!requested.tells_transmission && reported.transmission.stiffness > 0.0)
    for (const char* field : {"transmission_stiffness", "encoder_side"})
      requested.sources[field] = kOfTheDriver;
  if (!requested.tells_lag && reported.actuation.lag > 0.0)
    for (const char* field : {"actuation_lag", "actuation_kind"})
      requested.sources[field] = kOfTheDriver;
  requested.spec = reported;
  return requested;
}

double late_time(const DeviceSpec& spec, const DeviceEstimate& found) {
  return spec.actuation.late_ticks * found.tick;
}

SourcedSpec identified_spec(SourcedSpec known, const DeviceEstimate& found,
                            const std::string& date) {
  DeviceSpec& spec = known.spec;
  const int dof = spec.translation_dof;
  Vec3 damping = found.damping_bound;
  if (dof == 2) damping.z() = damping.head<2>().minCoeff();  // the z axis has no force
  spec.damping = damping;
  spec.apparent_mass = found.mass.head(dof).mean();
  spec.least_mass = std::min(found.mass_bound, spec.apparent_mass);
  spec.coulomb_friction = std::max(found.friction, 0.0);
  spec.least_friction = std::min(found.friction_bound, spec.coulomb_friction);
  // Treat the noise like a quantum of sqrt(12) times its RMS value.
  spec.position_resolution = std::max(found.quantum, std::sqrt(12.0) * found.noise);

  const std::string by = "identify, " + date;
  std::ostringstream noise, friction;
  noise << ": step " << found.quantum << " m, noise " << found.noise << " m RMS";
  friction << ": lower bound; estimate " << found.friction;
  known.sources["damping"] = by + ": lower bound; estimate " + listed(found.damping, dof);
  known.sources["apparent_mass"] = by + ": mean of " + listed(found.mass, dof);
  known.sources["least_mass"] = by + ": lower bound";
  known.sources["coulomb_friction"] = by;
  known.sources["least_friction"] = by + friction.str();
  known.sources["position_resolution"] = by + noise.str();
  if (found.lag_bound) {
    const double late = late_time(spec, found);
    const auto& [kind, lag] = told_lag(std::max(0.0, *found.lag_bound - late));
    spec.actuation.lag = lag;
    spec.actuation.kind = kind;
    std::ostringstream text;
    text << ": upper bound, of the reading too; estimate " << found.lag;
    if (late > 0.0) text << ", less " << late << " s of late_ticks";
    known.sources["actuation_lag"] = by + text.str();
    known.sources["actuation_kind"] = by;
    known.tells_lag = true;
  }
  if (found.transmission) tell_transmission(known, *found.transmission, by);
  validate(spec);
  return known;
}

std::string device_file_text(const SourcedSpec& described) {
  const DeviceSpec& spec = described.spec;
  nlohmann::ordered_json file = {{"name", spec.name},
                                 {"translation_dof", spec.translation_dof},
                                 {"rotation_sensed", spec.rotation_sensed},
                                 {"rotation_actuated", spec.rotation_actuated},
                                 {"damping", numbers(spec.damping)},
                                 {"apparent_mass", spec.apparent_mass},
                                 {"coulomb_friction", spec.coulomb_friction},
                                 {"position_resolution", spec.position_resolution},
                                 {"max_force", spec.max_force},
                                 {"continuous_force", spec.continuous_force},
                                 {"workspace", numbers(spec.workspace)},
                                 {"least_mass", spec.least_mass},
                                 {"least_friction", spec.least_friction},
                                 {"hand_force", spec.hand_force},
                                 {"hand_speed", spec.hand_speed},
                                 {"late_ticks", spec.actuation.late_ticks}};
  if (described.tells_lag) {
    file["actuation_lag"] = spec.actuation.lag;
    file["actuation_kind"] = kLagKindNames[static_cast<std::size_t>(spec.actuation.kind)];
  }
  if (described.tells_transmission) {
    file["transmission_stiffness"] = spec.transmission.stiffness;
    file["encoder_side"] =
        kEncoderSideNames[static_cast<std::size_t>(spec.transmission.encoder_side)];
  }
  if (spec.rotation_actuated != 0) {
    file["rotational_damping"] = numbers(spec.rotational_damping);
    file["max_torque"] = spec.max_torque;
    file["rotational_resolution"] = spec.rotation.resolution;
    file["least_inertia"] = spec.rotation.least_inertia;
    file["hand_torque"] = spec.rotation.hand_torque;
    file["apparent_inertia"] = spec.rotation.inertia;
    file["rotational_friction"] = spec.rotation.friction;
  }
  nlohmann::ordered_json sources = nlohmann::ordered_json::object();
  for (const auto& [field, source] : described.sources) sources[field] = source;
  file["sources"] = std::move(sources);
  return file.dump(2) + "\n";
}

}  // namespace feltwire
