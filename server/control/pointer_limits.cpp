#include "server/control/pointer_limits.hpp"

#include <spdlog/fmt/fmt.h>

namespace feltwire {

std::optional<std::string> beyond_pointer(const control::JoinRequest& request) {
  if (request.role != Role::pointer) return std::nullopt;
  if (!(request.device.max_force <= kPointerForce))
    return fmt::format(
        "a pointer's device has at most {} N, this one {}; join as operator, or with less",
        kPointerForce, request.device.max_force);
  // Tolerance for the rounding error of the period in the request.
  constexpr double kRounding = 1e-9;
  if (!(request.parameters.servo_period * kPointerRate >= 1.0 - kRounding))
    return fmt::format(
        "a pointer sends at most {} samples a second, this one {}; join as operator, or with a "
        "longer servo period",
        kPointerRate, 1.0 / request.parameters.servo_period);
  return std::nullopt;
}

}  // namespace feltwire
