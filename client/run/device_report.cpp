#include "client/run/device_report.hpp"

#include "client/transport/encoder.hpp"

namespace feltwire::report {
namespace {

/// Returns a number for isotropic damping, else the matrix by rows.
Json damping(const Damping& b) {
  if (b.isotropic()) return number(b.least());
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i)
    rows.push_back({number(b.matrix()(i, 0)), number(b.matrix()(i, 1)), number(b.matrix()(i, 2))});
  return rows;
}

/// Returns the result of a press against a wall, or null if there is no such wall.
Json felt(const FirstPress& felt) {
  if (!(felt.wall > 0.0)) return nullptr;
  return {{"wall_n_per_m", number(felt.wall)},
          {"share", number(felt.share)},
          {"share_at_encoder", number(felt.share_at_encoder)},
          {"swing_um", number(kMicro * felt.swing)}};
}

}  // namespace

Json device(const std::string& kind, const DeviceSpec& spec) {
  return {{"kind", kind},
          {"spec", spec.name},
          {"translation_dof", spec.translation_dof},
          {"rotation_sensed", spec.rotation_sensed},
          {"rotation_actuated", spec.rotation_actuated},
          {"damping", damping(spec.damping)},
          {"max_force_n", number(spec.max_force)},
          {"actuation_lag_s", number(spec.actuation.lag)},
          {"late_ticks", spec.actuation.late_ticks},
          {"transmission_n_per_m", spec.transmission.stiffness > 0.0
                                       ? Json(number(spec.transmission.stiffness))
                                       : Json(nullptr)},
          {"encoder_side",
           kEncoderSideNames[static_cast<std::size_t>(spec.transmission.encoder_side)]}};
}

Json safety(const SafetyLimits& s) {
  return {{"max_force_n", number(s.force.max)},
          {"velocity_limit_m_per_s", number(s.force.speed)},
          {"slew_n_per_s", number(s.force.slew)},
          {"ramp_up_s", number(s.ramp_up)},
          {"wait_for_small_force_n", number(s.force.small)}};
}

Json encoder(const DeviceSpec& spec, double scene_stiffness) {
  const bool known = spec.position_resolution > 0.0;
  const auto warning = encoder_warning(spec, scene_stiffness);
  return {
      {"quantum_m", known ? number(spec.position_resolution) : Json(nullptr)},
      {"coulomb_friction_n", number(spec.coulomb_friction)},
      {"stiffness_limit_n_per_m", number(encoder_stiffness_limit(spec))},
      {"scene_stiffness_n_per_m", scene_stiffness > 0.0 ? number(scene_stiffness) : Json(nullptr)},
      {"warning", warning ? Json(*warning) : Json(nullptr)}};
}

Json true_energy(const std::optional<TrueEnergy>& energy) {
  if (!energy) return nullptr;
  return {{"given_j", number(energy->given)},
          {"burned_j", number(energy->burned)},
          {"made_j", number(energy->made)},
          {"to_hand_j", number(energy->to_hand)}};
}

Json rehearsal(const std::optional<Rehearsal>& rehearsal) {
  if (!rehearsal) return nullptr;
  return {{"force_n", number(rehearsal->force)},
          {"scene", felt(rehearsal->scene)},
          {"calm_up_to", felt(rehearsal->calm)},
          {"whole_up_to", felt(rehearsal->whole)},
          {"most", felt(rehearsal->most)},
          {"mass_known", rehearsal->mass_known},
          {"swings", rehearsal->swings},
          {"transmission_n_per_m", number(rehearsal->transmission)}};
}

}  // namespace feltwire::report
