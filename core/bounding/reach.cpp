#include "core/bounding/reach.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

void refuse(const char* field, const char* part, double value, const char* remedy) {
  throw std::invalid_argument(std::string(field) + ": " + part + " is " + std::to_string(value) +
                              "; " + remedy);
}

}  // namespace

void validate(const PortKnowledge& port, const char* field) {
  validate(port.damping, field);
  const auto lower_bound = [&](const char* part, double value, const char* remedy) {
    if (!(value >= 0.0) || !std::isfinite(value)) refuse(field, part, value, remedy);
  };
  lower_bound("the Coulomb friction", port.coulomb_friction,
              "give a lower bound in N (N m), 0 when none is known");
  lower_bound("the encoder quantum", port.quantum, "give it in m (rad), 0 for an exact sensor");
  lower_bound("the mass", port.mass, "give a lower bound in kg (kg m^2), 0 when none is known");
  if (!(port.outside_force >= 0.0))  // infinity: unknown
    refuse(field, "the outside force", port.outside_force,
           "give an upper bound in N (N m), infinity when none is known");
  if (!(port.speed > 0.0))  // infinity: unknown
    refuse(field, "the speed", port.speed,
           "give an upper bound in m/s (rad/s) above 0, infinity when none is known");
}

void Reach::moved(const Vec3& displacement, const Vec3& held, double hold_time,
                  double period) noexcept {
  // A movement that is not known stays so until a whole sample has shown the speed again.
  const bool too_short = hold_time < 0.5 * period;
  const bool join = too_short && time_ > 0.0 && time_ < 0.5 * period;
  if (join) {
    if (!joined_) strongest_ = length(held_);
    strongest_ = std::max(strongest_, length(held));
    displacement_ += displacement;
    time_ += hold_time;
    joined_ = true;
    return;
  }
  displacement_ = displacement;
  held_ = held;
  time_ = hold_time;
  joined_ = false;
}

}  // namespace feltwire
