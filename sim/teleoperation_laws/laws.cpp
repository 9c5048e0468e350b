#include "sim/teleoperation_laws/laws.hpp"

#include <array>
#include <stdexcept>
#include <string>

#include "sim/teleoperation_laws/delayed_passivity.hpp"
#include "sim/teleoperation_laws/per_coordinate.hpp"
#include "sim/teleoperation_laws/position_force.hpp"
#include "sim/teleoperation_laws/position_position.hpp"
#include "sim/teleoperation_laws/remote_model.hpp"
#include "sim/teleoperation_laws/spatial_two_layer.hpp"
#include "sim/teleoperation_laws/two_layer.hpp"
#include "sim/teleoperation_laws/wave_variables.hpp"

namespace feltwire::teleop {
namespace {

using Law = std::unique_ptr<TeleoperationLaw>;
using InSpace = std::unique_ptr<SpatialLaw>;
/// A teleoperation law: its name, and the functions that make it for one and for three degrees of
/// freedom.
struct Entry {
  std::string_view name;
  Law (*make)(const Plant&);
  InSpace (*in_space)(const Plant&, const SurfaceModel&);
};
constexpr double kSoftLine = 10.0, kHardLine = 30.0;  // [N s/m] wave impedances

/// Returns a wrong model of the bench's wall: 2 mm too deep, a quarter too soft, and at rest.
SurfacePrior wrong_prior() {
  constexpr double kDeeper = 2e-3, kSofter = 1500.0;  // [m], [N/m]
  return {.key = 1,
          .point = Vec3(kDeeper, 0.0, 0.0),
          .normal = -Vec3::UnitX(),
          .stiffness = kSofter,
          .friction = 0.0,
          .velocity = Vec3::Zero()};
}

Law position_position(const Plant& p) { return std::make_unique<PositionPosition>(p, false); }
Law four_channel(const Plant& p) { return std::make_unique<PositionPosition>(p, true); }
Law soft_wave(const Plant& p) { return std::make_unique<WaveVariables>(p, kSoftLine); }
Law hard_wave(const Plant& p) { return std::make_unique<WaveVariables>(p, kHardLine); }
Law time_domain_passivity(const Plant& p) { return std::make_unique<DelayedPassivity>(p); }
Law two_layer(const Plant& p) { return std::make_unique<TwoLayer>(p); }
Law position_force(const Plant& p) { return std::make_unique<PositionForce>(p, "none"); }
Law energy_bounding(const Plant& p) { return std::make_unique<PositionForce>(p, "per_axis"); }
Law contact_frame(const Plant& p) { return std::make_unique<PositionForce>(p, "contact_frame"); }
Law two_port_force(const Plant& p) { return std::make_unique<PositionForceTwoPort>(p); }
Law feltwire(const Plant& p) { return std::make_unique<RemoteModel>(p); }
Law feltwire_prior(const Plant& p) { return std::make_unique<RemoteModel>(p, wrong_prior()); }

template <Law (*make)(const Plant&)>
InSpace on_each(const Plant& plant, const SurfaceModel& /*model*/) {
  return std::make_unique<PerCoordinate>([&] { return make(plant); });
}
template <class Whole>
InSpace whole(const Plant& plant, const SurfaceModel& /*model*/) {
  return std::make_unique<Whole>(plant);
}
InSpace projected(const Plant& p, const SurfaceModel& /*model*/) {
  return std::make_unique<SpatialPositionForce>(p, "per_axis_projected");
}
InSpace in_contact_frame(const Plant& p, const SurfaceModel& /*model*/) {
  return std::make_unique<SpatialPositionForce>(p, "contact_frame");
}
InSpace with_model(const Plant& p, const SurfaceModel& model) {
  return std::make_unique<SpatialRemoteModel>(p, model);
}

constexpr std::array kLaws = {
    Entry{"position_position", position_position, on_each<position_position>},
    Entry{"position_force", position_force, on_each<position_force>},
    Entry{"four_channel", four_channel, on_each<four_channel>},
    Entry{"wave_b10", soft_wave, on_each<soft_wave>},
    Entry{"wave_b30", hard_wave, on_each<hard_wave>},
    Entry{"time_domain_passivity", time_domain_passivity, on_each<time_domain_passivity>},
    Entry{"two_layer", two_layer, whole<SpatialTwoLayer>},
    Entry{"energy_bounding", energy_bounding, projected},
    Entry{"contact_frame", contact_frame, in_contact_frame},
    Entry{"two_port_force", two_port_force, whole<SpatialTwoPortForce>},
    Entry{"feltwire", feltwire, whole<SpatialRemoteModel>},
    Entry{"feltwire_prior", feltwire_prior, with_model},
};

const Entry& entry_of(std::string_view name) {
  std::string all;
  for (const Entry& entry : kLaws) {
    if (entry.name == name) return entry;
    all += (all.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("no teleoperation law '" + std::string(name) + "'; give one of " +
                              all);
}

}  // namespace

std::vector<std::string_view> law_names() {
  std::vector<std::string_view> names;
  names.reserve(kLaws.size());
  for (const Entry& entry : kLaws) names.push_back(entry.name);
  return names;
}

Law make_law(std::string_view name, const Plant& plant) { return entry_of(name).make(plant); }

InSpace make_spatial_law(std::string_view name, const Plant& plant, const SurfaceModel& model) {
  return entry_of(name).in_space(plant, model);
}

}  // namespace feltwire::teleop
