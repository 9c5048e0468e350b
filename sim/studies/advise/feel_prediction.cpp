#include "sim/studies/advise/feel_prediction.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "client/run/rehearsal.hpp"
#include "core/bounding/method.hpp"

namespace feltwire::advise {
namespace {

constexpr double kCalm = 10e-6;    // [m] RMS
constexpr double kWhole = 0.97;    // share of a wall at which nothing limits it
constexpr double kWorthIt = 1.02;  // least gain of a purchase that is told
// Band of a closed form, and of a rehearsal beyond its two hands: docs/lab/advise.md, "Bands".
constexpr double kFormBand = 0.05, kRehearsalBand = 0.10;
constexpr double kOverWall = 0.02;  // of a wall, by steps of the encoder

Felt by_damping(const DeviceSpec& device, const Setting& setting, double wall) {
  const double at_motor = std::min(wall, damping_limit(device, 1.0 / setting.rate));
  const double felt = in_series(at_motor, device.transmission.stiffness);
  return {.wall = wall,
          .felt = felt,
          .low = (1.0 - kFormBand) * felt,
          .high = (1.0 + kFormBand) * felt,
          .calm_share = wall > 0.0 ? felt / wall : 0.0};
}

Felt by_rehearsal(const DeviceSpec& device, const Setting& setting, double wall) {
  ServoOptions options;
  options.scene_stiffness = wall;
  const auto hands = first_presses(device, setting.parameters(), options, wall);
  if (hands.empty()) throw std::invalid_argument("this law has no rehearsal at the client");
  Felt felt{.wall = wall, .low = hands.front().stiffness(), .high = hands.front().stiffness()};
  const auto count = static_cast<double>(hands.size());
  double calm = 0.0, all = 0.0;
  for (const FirstPress& press : hands) {
    all += press.stiffness();
    if (press.calm()) {
      felt.felt += press.stiffness();
      calm += 1.0;
    }
    felt.low = std::min(felt.low, press.stiffness());
    felt.high = std::max(felt.high, press.stiffness());
    felt.swing = std::max(felt.swing, press.swing);
  }
  felt.calm_share = felt.felt / (count * wall);
  // Predict a hand that is calm, unless each one swings.
  felt.felt = calm > 0.0 ? felt.felt / calm : all / count;
  felt.low *= 1.0 - kRehearsalBand;
  felt.high = std::min((1.0 + kOverWall) * wall, felt.high * (1.0 + kRehearsalBand));
  return felt;
}

/// Adds what a changed device or setting would show.
class Shop {
 public:
  Shop(const DeviceSpec& device, const Setting& setting, double fade, Felt& felt)
      : device_(device), setting_(setting), fade_(fade), felt_(felt) {}

  template <class Change>
  void offer(Limit limit, std::string what, const Change& change) {
    DeviceSpec device = device_;
    Setting setting = setting_;
    change(device, setting);
    if (!is_possible(device, setting)) return;
    const Felt found = felt_of(device, setting, felt_.wall, fade_);
    if (found.felt > kWorthIt * felt_.felt && found.calm())
      felt_.purchases.push_back({limit, std::move(what), found.felt});
  }

 private:
  const DeviceSpec& device_;
  const Setting& setting_;
  double fade_;
  Felt& felt_;
};

Damping twice(const Damping& damping) {
  return damping.isotropic() ? Damping(2.0 * damping.least())
                             : Damping(Mat3(2.0 * damping.matrix()));
}

/// Offers what the account knows, which counts for a law that shapes alone.
void offer_knowledge(const DeviceSpec& device, Shop& shop) {
  if (!(device.least_mass > 0.0))
    shop.offer(Limit::mass, "a mass that is measured (feltwire-client identify)",
               [](DeviceSpec& d, Setting&) { d.least_mass = 0.8 * d.apparent_mass; });
  if (device.coulomb_friction > 0.0 && device.least_friction < 0.7 * device.coulomb_friction)
    shop.offer(Limit::friction, "a dry friction that is measured (feltwire-client identify)",
               [](DeviceSpec& d, Setting&) { d.least_friction = 0.8 * d.coulomb_friction; });
  shop.offer(Limit::friction, "twice the dry friction", [](DeviceSpec& d, Setting&) {
    d.least_friction *= 2.0;
    d.coulomb_friction *= 2.0;
  });
  shop.offer(Limit::quantum, "an encoder of a quarter of the quantum",
             [](DeviceSpec& d, Setting&) { d.position_resolution *= 0.25; });
  shop.offer(Limit::hand, "a hand of half the force (hand_force)",
             [](DeviceSpec& d, Setting&) { d.hand_force *= 0.5; });
}

}  // namespace

std::string_view name(Limit limit) { return kLimitNames[static_cast<std::size_t>(limit)]; }

bool Felt::calm() const { return swing < kCalm; }

double damping_limit(const DeviceSpec& device, double servo_period) {
  const double late = device.actuation.lag + device.actuation.late_ticks * servo_period;
  return 2.0 * device.damping.least() / (servo_period + 2.0 * late);
}

bool is_possible(const DeviceSpec& device, const Setting& setting) {
  try {
    const Servo servo(device, setting.parameters(), ServoOptions{});
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

double in_series(double stiffness, double behind) {
  return behind > 0.0 ? stiffness * behind / (stiffness + behind) : stiffness;
}

Felt felt_of(const DeviceSpec& device, const Setting& setting, double wall, double fade) {
  const bool shapes = bounding_method(setting.law).shapes;
  Felt felt = shapes ? by_rehearsal(device, setting, wall) : by_damping(device, setting, wall);
  for (double* stiffness : {&felt.felt, &felt.low, &felt.high}) *stiffness *= fade;
  return felt;
}

Felt explained(const DeviceSpec& device, const Setting& setting, double wall, double fade,
               double most_rate) {
  Felt felt = felt_of(device, setting, wall, fade);
  if (felt.share() >= kWhole && felt.calm()) return felt;
  Shop shop(device, setting, fade, felt);
  shop.offer(Limit::damping, "twice the damping",
             [](DeviceSpec& d, Setting&) { d.damping = twice(d.damping); });
  if (bounding_method(setting.law).shapes) offer_knowledge(device, shop);
  if (device.transmission.stiffness > 0.0)
    shop.offer(Limit::transmission, "a transmission of twice the stiffness",
               [](DeviceSpec& d, Setting&) { d.transmission.stiffness *= 2.0; });
  if (device.actuation.lag > 0.0)
    shop.offer(Limit::lag, "half the lag of the motor",
               [](DeviceSpec& d, Setting&) { d.actuation.lag *= 0.5; });
  if (2.0 * setting.rate <= most_rate)
    shop.offer(Limit::rate, "twice the servo rate", [](DeviceSpec&, Setting& s) { s.rate *= 2.0; });
  if (fade < kWhole)
    felt.purchases.push_back({Limit::loss, "a link without loss", felt.felt / fade});
  std::ranges::stable_sort(felt.purchases,
                           [](const Purchase& a, const Purchase& b) { return a.felt > b.felt; });
  if (!felt.purchases.empty()) felt.limit = felt.purchases.front().limit;
  return felt;
}

}  // namespace feltwire::advise
