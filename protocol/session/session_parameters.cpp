#include "protocol/session/session_parameters.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "core/base/enum_names.hpp"

namespace feltwire {
namespace {

constexpr double kLargestOperatorDamping = 100.0;  // [N s/m]
constexpr double kLargestCutoff = 1e5;  // [Hz] This is at least half the highest servo rate.
constexpr double kLongestHold = 1.0;    // [s]
constexpr double kLargestCouplingDamping = 1e6;              // [N s/m]
constexpr double kLightestTool = 1e-6, kHeaviestTool = 1e3;  // [kg]

std::string short_text(double number) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%g", number);
  return text.data();
}

/// Throws if the value is outside the range, or if it is NaN.
void within(const char* field, double value, double low, double high, const char* unit,
            const char* remedy) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument(std::string(field) + " = " + short_text(value) + " is not within " +
                              short_text(low) + " to " + short_text(high) +
                              (*unit != '\0' ? " " : "") + unit + "; " + remedy);
}

void known(const char* field, std::size_t value, std::size_t choices) {
  if (value >= choices)
    throw std::invalid_argument(std::string(field) + " = " + std::to_string(value) +
                                " is none of the " + std::to_string(choices) +
                                " there are; take one by its name");
}

/// Checks the parameters that determine the traffic.
void validate_traffic(const SessionParameters& p) {
  known("predictor", static_cast<std::size_t>(p.predictor), kPredictorNames.size());
  within("packet_interval", p.packet_interval, 1, kMaxPacketInterval, "servo ticks",
         "1 sends every sample");
  within("batch", p.batch, 1, std::min(p.packet_interval, kMaxRedundancy + 1 - p.redundancy),
         "samples", "it is at most packet_interval, and with the redundancy at most 9");
  within("position_deadband", p.position_deadband, 0.0, kMaxDeadband, "", "0.1 is rarely felt");
  within("force_deadband", p.force_deadband, 0.0, kMaxDeadband, "", "0.1 is rarely felt");
  const double interval = p.packet_interval * p.servo_period;
  if (!(interval <= p.hold_time))
    throw std::invalid_argument("packet_interval = " + std::to_string(p.packet_interval) +
                                " ticks is longer than the hold_time of " +
                                short_text(p.hold_time) +
                                " s: the force would be gone before the next datagram; lower it "
                                "or raise hold_time");
  within("keep_alive", p.keep_alive, 0.0, kLongestHold, "s", "0.02 suits most lines");
  // The times without packets of both sides add up, so two deadbands halve the limit.
  const bool both = p.position_deadband > 0.0 && p.force_deadband > 0.0;
  if (p.position_deadband > 0.0 || p.force_deadband > 0.0)
    within("keep_alive", p.keep_alive, interval, (both ? 0.25 : 0.5) * p.hold_time, "s",
           both ? "it lasts at least packet_interval, commands fade from half of hold_time, and "
                  "with both deadbands a reply may be two keep_alive late"
                : "it lasts at least packet_interval, and commands fade from half of hold_time");
  if (p.local_model && p.side == BoundingSide::server)
    throw std::invalid_argument(
        "local_model makes forces beside the device, which the side server does not bound: use "
        "the side client or both");
  if (p.predictor == Predictor::linear && p.position_deadband > 0.0 && !p.local_model)
    throw std::invalid_argument(
        "predictor linear with a position_deadband says nothing while the hand moves evenly, into "
        "a "
        "wall too: turn local_model on, or use the predictor level");
}

}  // namespace

void validate(const SessionParameters& p) {
  const BoundingMethod& method = bounding_method(p.mode);
  known("projection", static_cast<std::size_t>(p.projection), kProjectionNames.size());
  known("storage", static_cast<std::size_t>(p.storage), kStorageNames.size());
  known("reference", static_cast<std::size_t>(p.reference), kPassivityReferenceNames.size());
  known("side", static_cast<std::size_t>(p.side), kBoundingSideNames.size());
  within("servo_period", p.servo_period, kShortestServoPeriod, kLongestServoPeriod, "s",
         "1e-3 is a haptic servo's usual period");
  within("redundancy", p.redundancy, 0, kMaxRedundancy, "samples", "3 bridges two lost packets");
  within("operator_damping", p.operator_damping, 0.0, kLargestOperatorDamping, "N s/m",
         "0 credits nothing and is always safe");
  within("velocity_cutoff", p.velocity_cutoff, 0.0, kLargestCutoff, "Hz", "0 filters nothing");
  within("hold_time", p.hold_time, p.servo_period, kLongestHold, "s",
         "it must last at least one servo period");
  if (p.c1) within("c1", *p.c1, 0.0, kStiffest, "N/m", "leave it out for b/T");
  if (p.c2) within("c2", *p.c2, 0.0, kStiffest, "N/m", "leave it out for c1");
  if (p.c1 && p.c2 && *p.c2 > *p.c1)
    throw std::invalid_argument("c2 = " + short_text(*p.c2) +
                                " is above c1 = " + short_text(*p.c1) +
                                " N/m: the bounding laws would contradict each other; lower c2 or "
                                "raise c1");
  if (p.coupling_stiffness)
    within("coupling_stiffness", *p.coupling_stiffness, 0.0, kStiffest, "N/m",
           "leave it out for b/T");
  if (p.coupling_damping)
    within("coupling_damping", *p.coupling_damping, 0.0, kLargestCouplingDamping, "N s/m",
           "leave it out for b - k T / 2");
  within("tool_mass", p.tool_mass, kLightestTool, kHeaviestTool, "kg", "0.05 is a light tool");
  if (method.shapes && p.side != BoundingSide::client)
    throw std::invalid_argument("the mode " + p.mode +
                                " bounds nothing by itself: the account behind it stands at the "
                                "client; use the side client");
  if (stands_beside_scene(method) && p.side != BoundingSide::server)
    throw std::invalid_argument("the mode " + p.mode +
                                " asks the scene at its own tool, which only the server can: "
                                "use the side server");
  validate_traffic(p);
}

SessionParameters usual_parameters() {
  SessionParameters parameters;
  parameters.mode = kSessionMethod;
  parameters.local_model = true;
  return parameters;
}

BoundingConfig bounding_config(const SessionParameters& p, const DeviceSpec& device) {
  BoundingConfig config;
  const BoundingMethod& method = bounding_method(p.mode);
  config.mode = method.name;
  config.projection = p.projection;
  config.storage = p.storage;
  config.period = p.servo_period;
  config.lag = device.actuation.lag;
  config.damping = device.damping;
  if (!method.shapes)
    config.damping += p.operator_damping;
  else if (p.operator_damping > 0.0)
    config.hand_damping = p.operator_damping;
  config.quantum = device.position_resolution;
  config.rotational_damping = device.rotational_damping;
  config.c1 = p.c1;
  config.c2 = p.c2;
  config.max_force = device.max_force;
  config.max_torque = device.max_torque;
  config.rotation = device.rotation_actuated > 0;
  config.reference = p.reference;
  config.coupling = {p.coupling_stiffness, p.coupling_damping, p.tool_mass};
  return config;
}

std::string_view name(BoundingSide side) { return enum_name(kBoundingSideNames, side); }
BoundingSide bounding_side(std::string_view given) {
  return enum_from_name<BoundingSide>("bounding side", given, kBoundingSideNames);
}

std::string_view name(Predictor predictor) { return enum_name(kPredictorNames, predictor); }
Predictor predictor(std::string_view given) {
  return enum_from_name<Predictor>("predictor", given, kPredictorNames);
}

}  // namespace feltwire
