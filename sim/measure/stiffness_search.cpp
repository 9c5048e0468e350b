#include "sim/measure/stiffness_search.hpp"

#include <cmath>
#include <stdexcept>

namespace feltwire {

StiffnessLimit largest_calm(const StiffnessRange& range, const std::function<bool(double)>& calm) {
  const bool usable = range.lowest > 0.0 && range.highest > range.lowest &&
                      std::isfinite(range.highest) && range.per_decade >= 1 &&
                      range.tolerance > 0.0;
  if (!usable)
    throw std::invalid_argument(
        "a range of stiffnesses must be 0 < lowest < highest [N/m], with a point or more a decade "
        "and a tolerance above zero");
  const double factor = std::pow(10.0, 1.0 / range.per_decade);
  double good = 0.0, bad = range.lowest;
  while (calm(bad)) {
    good = bad;
    if (good == range.highest) return {good, true};
    bad = good * factor * (1.0 + 1e-9) < range.highest ? good * factor : range.highest;
  }
  if (good == 0.0) return {};
  while (bad > good * (1.0 + range.tolerance)) {
    const double middle = std::sqrt(good * bad);
    (calm(middle) ? good : bad) = middle;
  }
  return {good, false};
}

}  // namespace feltwire
