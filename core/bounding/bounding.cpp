#include "core/bounding/bounding.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "core/bounding/bounding_template.hpp"

namespace feltwire {
namespace {

constexpr double kShortestPeriod = 1e-12;  // [s] shortest accepted servo period

void require(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

/// Checks the constants c1 and c2 [N/m or N m/rad] of one port. The check applies to every mode,
/// because every configuration may set them.
void check_constants(const Damping& damping, double period, std::optional<double> given_c1,
                     std::optional<double> given_c2, const std::string& suffix) {
  const Vec3 b = damping.per_axis();
  for (int i = 0; i < 3; ++i) {
    const double c1 = given_c1.value_or(b[i] / period), c2 = given_c2.value_or(c1);
    require(c1 >= 0.0 && c1 <= kLargestStiffness,
            "c1" + suffix + " must be finite and not negative");
    require(c2 >= 0.0 && c2 <= kLargestStiffness,
            "c2" + suffix + " must be finite and not negative");
    require(c2 <= c1, "c2" + suffix + " = " + std::to_string(c2) + " is above c1" + suffix + " = " +
                          std::to_string(c1) +
                          ": the bounding laws would contradict each other; lower c2 or raise c1");
  }
}

}  // namespace

void bounding_detail::check(const BoundingConfig& c, std::string_view method,
                            bool needs_every_axis_damped) {
  require(std::isfinite(c.period) && c.period > 0.0, "period must be finite and above zero [s]");
  require(c.period >= kShortestPeriod, "period is too short; give seconds");
  require(std::isfinite(c.lag) && c.lag >= 0.0, "lag must be finite and not negative [s]");
  validate(c.damping, "damping");
  validate(c.rotational_damping, "rotational damping");
  require(2.0 * c.damping.matrix().cwiseAbs().maxCoeff() / c.period <= kLargestStiffness,
          "damping over period is too large; give a longer period or less damping");
  require(2.0 * c.rotational_damping.matrix().cwiseAbs().maxCoeff() / c.period <= kLargestStiffness,
          "rotational damping over period is too large; give a longer period or less damping");
  if (needs_every_axis_damped) {
    const std::string remedy = std::string(" must be above zero along every axis for the mode ") +
                               std::string(method) +
                               "; give an axis that hardly has any a small one";
    require(Metric<double>::usable(c.damping), "damping" + remedy);
    require(!c.rotation || Metric<double>::usable(c.rotational_damping),
            "rotational damping" + remedy);
  }
  require(c.max_force > 0.0, "max force must be above zero [N]");
  require(c.max_torque >= 0.0, "max torque must not be negative [N m]");
  check_constants(c.damping, c.reckoned_period(), c.c1, c.c2, "");
  check_constants(c.rotational_damping, c.reckoned_period(), c.c1_rotation, c.c2_rotation,
                  " (rotation)");
}

template <>
BasicBounding<double>::BasicBounding(const BoundingConfig& config)
    : BasicBounding(bounding_method(config.mode), config) {}

template class BasicBounding<double>;

}  // namespace feltwire
