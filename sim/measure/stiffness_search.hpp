#pragma once

#include <functional>

namespace feltwire {

/// A range of stiffnesses, and the resolution of the search.
struct StiffnessRange {
  double lowest = 10.0, highest = 1e6;  // [N/m], 0 < lowest < highest
  int per_decade = 6;                   // >= 1: points of the scan
  double tolerance = 0.03;              // > 0, relative
};

struct StiffnessLimit {
  double stiffness = 0.0;    // [N/m] the largest calm one found; 0 if not even the lowest is calm
  bool above_range = false;  // the whole range is calm: the limit is `highest` or more
};

/// The end of the calm stiffnesses that begin at `lowest`: a scan upward on a logarithmic grid,
/// because calm is not monotonic in stiffness, then bisection between the last calm point and the
/// first that is not. It does not search for a calm island beyond that, because a builder cannot
/// use it. Throws std::invalid_argument for an impossible range.
StiffnessLimit largest_calm(const StiffnessRange& range, const std::function<bool(double)>& calm);

}  // namespace feltwire
