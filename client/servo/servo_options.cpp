#include "client/servo/servo_options.hpp"

#include <sstream>
#include <stdexcept>
#include <string_view>

#include "client/servo/servo_law.hpp"

namespace feltwire {
namespace {

void refuse_beside(std::string_view mode, const char* what, double value, const char* unit,
                   double off) {
  if (value == off) return;
  std::ostringstream message;
  message << "a " << what << " of " << value << " " << unit << " cannot follow the bounding mode "
          << mode << ", which also bounds forces from below; use "
          << "contact_frame or no " << what << " (" << off << ")";
  throw std::invalid_argument(message.str());
}

}  // namespace

void validate(const ServoOptions& options, const SessionParameters& parameters) {
  const SafetyLimits& s = options.safety;
  validate(s);
  if (const char* why = needs_account(parameters); why != nullptr && !options.account)
    throw std::invalid_argument("the force of the mode " + parameters.mode + why +
                                " is passive by the account alone; keep the account, or choose a "
                                "mode of a paper at the client");
  if (admits_reduction(parameters)) return;
  refuse_beside(parameters.mode, "slew limit", s.force.slew, "N/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "slew limit", s.torque.slew, "N m/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "velocity limit", s.force.speed, "m/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "velocity limit", s.torque.speed, "rad/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "ramp-up", s.ramp_up, "s", 0.0);
}

ServoOptions protect_hand(const SessionParameters& parameters) {
  ServoOptions options;
  options.safety.force.small = 0.05;   // [N] less than a resting hand can feel
  options.safety.torque.small = 2e-3;  // [N m] the same force at an arm of 40 mm
  if (!admits_reduction(parameters)) return options;
  options.safety.force.speed = 1.5;  // [m/s] fastest hand that gets the whole force
  // A force bound at the client starts from zero force without a ramp. A ramp after the bound would
  // withhold force. Measurements show that this force returns only as the hand presses deeper.
  const bool client_bounds =
      parameters.side != BoundingSide::server && parameters.mode != kUnbounded;
  if (!client_bounds) options.safety.ramp_up = 0.2;  // [s] duration of the ramp
  return options;
}

}  // namespace feltwire
