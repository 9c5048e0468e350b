#include "sim/teleoperation_laws/laws.hpp"

#include <array>
#include <stdexcept>
#include <string>

#include "sim/teleoperation_laws/delayed_passivity.hpp"
#include "sim/teleoperation_laws/position_force.hpp"
#include "sim/teleoperation_laws/position_position.hpp"
#include "sim/teleoperation_laws/remote_model.hpp"
#include "sim/teleoperation_laws/two_layer.hpp"
#include "sim/teleoperation_laws/wave_variables.hpp"

namespace feltwire::teleop {
namespace {

using Law = std::unique_ptr<TeleoperationLaw>;
struct Entry {
  std::string_view name;
  Law (*make)(const Plant&);
};
constexpr double kSoftLine = 10.0, kHardLine = 30.0;  // [N s/m] of the wave variables

/// The wall of the bench, 2 mm deeper and a quarter softer than it is. It says nothing of a motion.
SurfacePrior wrong_prior() {
  constexpr double kDeeper = 2e-3, kSofter = 1500.0;  // [m], [N/m]
  return {.key = 1,
          .point = Vec3(kDeeper, 0.0, 0.0),
          .normal = -Vec3::UnitX(),
          .stiffness = kSofter,
          .friction = 0.0,
          .velocity = Vec3::Zero()};
}

const std::array kLaws = {
    Entry{"position_position",
          [](const Plant& p) -> Law { return std::make_unique<PositionPosition>(p, false); }},
    Entry{"position_force",
          [](const Plant& p) -> Law { return std::make_unique<PositionForce>(p, "none"); }},
    Entry{"four_channel",
          [](const Plant& p) -> Law { return std::make_unique<PositionPosition>(p, true); }},
    Entry{"wave_b10",
          [](const Plant& p) -> Law { return std::make_unique<WaveVariables>(p, kSoftLine); }},
    Entry{"wave_b30",
          [](const Plant& p) -> Law { return std::make_unique<WaveVariables>(p, kHardLine); }},
    Entry{"time_domain_passivity",
          [](const Plant& p) -> Law { return std::make_unique<DelayedPassivity>(p); }},
    Entry{"two_layer", [](const Plant& p) -> Law { return std::make_unique<TwoLayer>(p); }},
    Entry{"energy_bounding",
          [](const Plant& p) -> Law { return std::make_unique<PositionForce>(p, "per_axis"); }},
    Entry{
        "contact_frame",
        [](const Plant& p) -> Law { return std::make_unique<PositionForce>(p, "contact_frame"); }},
    Entry{"two_port_force",
          [](const Plant& p) -> Law { return std::make_unique<PositionForceTwoPort>(p); }},
    Entry{"feltwire", [](const Plant& p) -> Law { return std::make_unique<RemoteModel>(p); }},
    Entry{"feltwire_prior",
          [](const Plant& p) -> Law { return std::make_unique<RemoteModel>(p, wrong_prior()); }},
};

}  // namespace

std::vector<std::string_view> law_names() {
  std::vector<std::string_view> names;
  names.reserve(kLaws.size());
  for (const Entry& entry : kLaws) names.push_back(entry.name);
  return names;
}

Law make_law(std::string_view name, const Plant& plant) {
  std::string all;
  for (const Entry& entry : kLaws) {
    if (entry.name == name) return entry.make(plant);
    all += (all.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("no teleoperation law '" + std::string(name) + "'; give one of " +
                              all);
}

}  // namespace feltwire::teleop
