#pragma once
// The feel of a wall: the displayed stiffness at rest, its band, and what limits it.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/device/device_spec.hpp"
#include "sim/studies/advise/advice_setting.hpp"

namespace feltwire::advise {

/// The part that limits a session.
enum class Limit {
  nothing,
  damping,       // of the device
  friction,      // dry, as far as the account knows it
  quantum,       // of the encoder
  mass,          // the account does not know the mass
  hand,          // the account assumes a hand of 10 N
  transmission,  // between motor and handle
  lag,           // of the motor
  motor,         // its force
  rate,          // of the servo
  delay,
  loss,
  line,  // the bit rate of the link
  cpu
};
inline constexpr std::array<std::string_view, 14> kLimitNames = {"nothing",      "device damping",
                                                                 "dry friction", "encoder quantum",
                                                                 "unknown mass", "assumed hand",
                                                                 "transmission", "motor lag",
                                                                 "motor force",  "servo rate",
                                                                 "delay",        "loss",
                                                                 "line rate",    "CPU"};
std::string_view name(Limit limit);

/// The gain of a better part.
struct Purchase {
  Limit limit = Limit::nothing;
  std::string what;   // "twice the damping"
  double felt = 0.0;  // [N/m] with it
};

struct Felt {
  double wall = 0.0;                         // [N/m] the material
  double felt = 0.0, low = 0.0, high = 0.0;  // [N/m] at the handle, at rest, after a first press
  double swing = 0.0;                        // [m] RMS of the handle, at rest
  /// The share of the wall, in the mean over the hands; a hand that swings feels 0.
  double calm_share = 0.0;
  double share() const { return wall > 0.0 ? felt / wall : 0.0; }
  bool calm() const;
  Limit limit = Limit::nothing;
  std::vector<Purchase> purchases = {};  // the largest gain first
};

/// [N/m] 2b/(T + 2L): the most that a law displays which relies on the device's damping alone
/// (docs/bounding.md). The least damping of any direction counts. L: motor lag and late ticks.
double damping_limit(const DeviceSpec& device, double servo_period);

/// Whether a client accepts this law and rate for this device: the account refuses a lag of too
/// many servo periods.
bool is_possible(const DeviceSpec& device, const Setting& setting);

/// [N/m] of two springs in a row. A stiffness of 0 behind: rigid.
double in_series(double stiffness, double behind);

/// A first press. `fade`: the share of a command that the link leaves (mean_fade()). Without
/// purchases and limit. Precondition: the setting has a local model.
/// Throws std::invalid_argument where the rehearsal is not possible.
Felt felt_of(const DeviceSpec& device, const Setting& setting, double wall, double fade);

/// felt_of() with purchases and limit. `most_rate` [Hz].
Felt explained(const DeviceSpec& device, const Setting& setting, double wall, double fade,
               double most_rate);

}  // namespace feltwire::advise
