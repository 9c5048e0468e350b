#include "client/hands/plant.hpp"

#include <cmath>

#include "core/base/text.hpp"

namespace feltwire {
namespace {

// Largest (and least) valid values. No device and no hand exceeds them, so a larger number probably
// has the wrong unit.
constexpr double kMostLag = 0.05;           // [s]
constexpr double kMostPlantForce = 100.0;   // [N]
constexpr double kMostStiffness = 1e9;      // [N/m]
constexpr double kMostPlantDamping = 1e4;   // [N s/m]
constexpr double kMostPlantMass = 100.0;    // [kg]
constexpr double kMostWidth = 0.01;         // [m]
constexpr double kMostVelocity = 10.0;      // [m/s]
constexpr double kMostReflexDelay = 0.2;    // [s]
constexpr double kLeastReflexDelay = 1e-3;  // [s]
constexpr double kMostGrip = 10.0;          // grip factor
constexpr double kMostGripTime = 1e7;       // [s]

std::string short_number(double value) {
  std::string text;
  append(text, "%g", value);
  return text;
}

void check_plant_range(const std::string& field, double value, double most, const char* unit) {
  if (value >= 0.0 && value <= most) return;
  throw PlantError(field, "must be from 0 to " + short_number(most) + " " + unit + ", is " +
                              short_number(value) + "; check the unit");
}

void check_stiffness(const std::string& field, double value) {
  if (value > 0.0 && value <= kMostStiffness) return;
  throw PlantError(field, "must be above 0 and at most " + short_number(kMostStiffness) +
                              " N/m, is " + short_number(value) +
                              "; leave it out for a rigid part");
}

void check_transmission(const Plant::Transmission& t) {
  check_plant_range("transmission.damping", t.damping, kMostPlantDamping, "N s/m");
  check_plant_range("transmission.backlash", t.backlash, kMostWidth, "m");
  check_plant_range("transmission.handle_mass", t.handle_mass, kMostPlantMass, "kg");
  if (t.rigid()) {
    if (t.damping > 0.0 || t.backlash > 0.0 || t.handle_mass > 0.0)
      throw PlantError("transmission.stiffness",
                       "is missing, and a rigid transmission has no damping, no backlash and no "
                       "handle of its own; give it [N/m], or leave the transmission out");
    return;
  }
  check_stiffness("transmission.stiffness", t.stiffness);
  if (!(t.handle_mass > 0.0))
    throw PlantError("transmission.handle_mass",
                     "must be above 0 kg, because the handle moves by itself behind a transmission "
                     "that gives; give the part of the device's apparent mass that is there");
}

void check_reflex(const Plant::HeldHand& hand) {
  check_plant_range("hand.reflex_stiffness", hand.reflex_stiffness, kMostStiffness, "N/m");
  check_plant_range("hand.reflex_damping", hand.reflex_damping, kMostPlantDamping, "N s/m");
  if (!hand.has_reflex() && hand.reflex_delay == 0.0) return;
  if (!(hand.reflex_delay >= kLeastReflexDelay && hand.reflex_delay <= kMostReflexDelay))
    throw PlantError("hand.reflex_delay", "must be from 0.001 to 0.2 s, is " +
                                              short_number(hand.reflex_delay) +
                                              "; what acts at once is the hand's own stiffness");
}

void check_grip(const std::vector<Plant::Grip>& grip) {
  double last = -1.0;
  for (std::size_t i = 0; i < grip.size(); ++i) {
    const std::string field = "hand.grip[" + std::to_string(i) + "]";
    check_plant_range(field + ".time", grip[i].time, kMostGripTime, "s");
    check_plant_range(field + ".share", grip[i].share, kMostGrip, "of the hand's stiffness");
    if (!(grip[i].time > last))
      throw PlantError(field + ".time", "is not after the one before; give rising times");
    last = grip[i].time;
  }
}

void check_hand(const Plant::HeldHand& hand) {
  if (hand.mass) check_plant_range("hand.mass", *hand.mass, kMostPlantMass, "kg");
  if (hand.damping) check_plant_range("hand.damping", *hand.damping, kMostPlantDamping, "N s/m");
  if (hand.stiffness) check_plant_range("hand.stiffness", *hand.stiffness, kMostStiffness, "N/m");
  check_plant_range("hand.pad_damping", hand.pad_damping, kMostPlantDamping, "N s/m");
  if (hand.has_pad()) check_stiffness("hand.pad_stiffness", hand.pad_stiffness);
  if (!hand.has_pad() && !(hand.pad_stiffness > 0.0))  // also refuses NaN
    throw PlantError("hand.pad_stiffness", "is no number; leave it out for a hand without a pad");
  if (!hand.has_pad() && hand.pad_damping > 0.0)
    throw PlantError("hand.pad_stiffness",
                     "is missing beside pad_damping; give it [N/m], or leave both out");
  check_reflex(hand);
  check_grip(hand.grip);
}

}  // namespace

bool Plant::ideal() const noexcept {
  const bool direct = amplifier.lag == 0.0 && amplifier.delay == 0.0 && amplifier.jitter == 0.0 &&
                      amplifier.resolution == 0.0;
  const bool plain = !hand.has_pad() && !hand.has_reflex() && hand.grip.empty();
  return direct && transmission.rigid() && friction.breakaway == 0.0 && encoder.noise == 0.0 &&
         plain;
}

void validate(const Plant& plant) {
  const Plant::Amplifier& a = plant.amplifier;
  check_plant_range("amplifier.lag", a.lag, kMostLag, "s");
  check_plant_range("amplifier.delay", a.delay, kMostLag, "s");
  check_plant_range("amplifier.jitter", a.jitter, kMostLag, "s");
  check_plant_range("amplifier.resolution", a.resolution, kMostPlantForce, "N");
  check_transmission(plant.transmission);
  check_plant_range("friction.breakaway", plant.friction.breakaway, kMostPlantForce, "N");
  check_plant_range("friction.stribeck_velocity", plant.friction.stribeck_velocity, kMostVelocity,
                    "m/s");
  if (plant.friction.breakaway > 0.0 && !(plant.friction.stribeck_velocity > 0.0))
    throw PlantError("friction.stribeck_velocity",
                     "must be above 0 m/s beside a breakaway force: the speed at which most of it "
                     "is gone, for example 0.001");
  check_plant_range("encoder.noise", plant.encoder.noise, kMostWidth, "m");
  check_hand(plant.hand);
}

void validate(const Plant& plant, const DeviceSpec& spec) {
  validate(plant);
  const double handle = plant.transmission.handle_mass;
  if (!plant.transmission.rigid() && !(handle < spec.apparent_mass))
    throw PlantError("transmission.handle_mass",
                     "is " + short_number(handle) + " kg of the device's apparent mass of " +
                         short_number(spec.apparent_mass) +
                         " kg; give less, because the motor has the rest");
  const double breakaway = plant.friction.breakaway;
  if (breakaway > 0.0 && !(breakaway >= spec.coulomb_friction))
    throw PlantError("friction.breakaway", "is " + short_number(breakaway) +
                                               " N, less than the device's dry friction of " +
                                               short_number(spec.coulomb_friction) +
                                               " N; give as much or more");
  if (plant.hand.has_pad() && plant.transmission.rigid() && !(spec.apparent_mass > 0.0))
    throw PlantError("hand.pad_stiffness",
                     "needs a device with an apparent mass above 0 kg; give it in --spec or as "
                     "mass of --device");
}

Hand held_by(const Plant& plant, Hand hand) {
  const Plant::HeldHand& held = plant.hand;
  if (!held.mass && !held.damping && !held.stiffness) return hand;
  hand.mass = held.mass.value_or(hand.mass);
  hand.damping = held.damping.value_or(hand.damping);
  hand.stiffness = held.stiffness.value_or(hand.stiffness);
  return with_wrist(hand);
}

}  // namespace feltwire
