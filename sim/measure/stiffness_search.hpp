#pragma once

#include <functional>

namespace feltwire {

/// A range of stiffnesses and how finely it is searched.
struct StiffnessRange {
  double lowest = 10.0, highest = 1e6;  // [N/m], 0 < lowest < highest
  int per_decade = 6;                   // >= 1: points of the scan
  double tolerance = 0.03;              // > 0, relative
};

struct StiffnessLimit {
  double stiffness = 0.0;    // [N/m] the largest that was found calm; 0 when not even the lowest is
  bool above_range = false;  // the whole range is calm: the limit is `highest` or more
};

/// The end of the calm stiffnesses that begin at `lowest`: a scan upward on a logarithmic grid, as
/// calm is not monotonic in stiffness, then bisection between the last calm and the first point
/// that is not. An island of calm beyond that is not looked for: a builder cannot use it.
/// Throws std::invalid_argument for a range that cannot be searched.
StiffnessLimit largest_calm(const StiffnessRange& range, const std::function<bool(double)>& calm);

}  // namespace feltwire
