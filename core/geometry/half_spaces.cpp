#include "core/geometry/half_spaces.hpp"

#include <cmath>

namespace feltwire {
namespace {

/// Below this sine, two planes count as parallel, and three planes count as meeting in a line.
constexpr double kParallel = 1e-9;
constexpr int kMostActive = 3;

using Subset = std::array<std::size_t, kMostActive>;

/// Finds the point on all these planes that is nearest to the goal. Returns false if the planes do
/// not determine this point, or if a plane would have to pull the goal instead of pushing it.
bool on_planes(std::span<const HalfSpace> all, const Subset& which, int count, const Vec3& goal,
               Vec3& point) {
  const HalfSpace& a = all[which[0]];
  if (count == 1) {
    const double under = -a.height(goal);
    point = goal + under * a.normal;
    return under >= 0.0;
  }
  const HalfSpace& b = all[which[1]];
  if (count == 2) {
    const double c = a.normal.dot(b.normal);
    const double sine = a.normal.cross(b.normal).squaredNorm();
    if (!(sine > kParallel * kParallel)) return false;
    const double ua = -a.height(goal), ub = -b.height(goal);
    const double pa = (ua - c * ub) / sine, pb = (ub - c * ua) / sine;
    point = goal + pa * a.normal + pb * b.normal;
    return pa >= 0.0 && pb >= 0.0;
  }
  const HalfSpace& c = all[which[2]];
  const Vec3 bc = b.normal.cross(c.normal), ca = c.normal.cross(a.normal),
             ab = a.normal.cross(b.normal);
  const double volume = a.normal.dot(bc);
  if (!(std::abs(volume) > kParallel)) return false;
  const Vec3 shift = (-a.height(goal) * bc - b.height(goal) * ca - c.height(goal) * ab) / volume;
  point = goal + shift;
  return shift.dot(bc) / volume >= 0.0 && shift.dot(ca) / volume >= 0.0 &&
         shift.dot(ab) / volume >= 0.0;
}

}  // namespace

NearestPoint nearest_in(std::span<const HalfSpace> spaces, const Vec3& goal, double tolerance,
                        WorkLimit* work) noexcept {
  constexpr int kMostRounds = 64;
  constexpr std::uint64_t kRoundWork = 8;
  NearestPoint best{.point = goal, .active = {}, .count = 0, .found = true};
  for (int round = 0; round < kMostRounds; ++round) {
    std::size_t worst = 0;
    double lowest = -tolerance;
    for (std::size_t i = 0; i < spaces.size(); ++i) {
      const double height = spaces[i].height(best.point);
      if (!(height < lowest)) continue;
      lowest = height;
      worst = i;
    }
    if (!(lowest < -tolerance)) return best;
    if (!may_go_on(work, kRoundWork)) break;

    // Find a point that satisfies the worst plane and the active planes. It lies on the worst plane
    // and on a subset of the active planes.
    NearestPoint next;
    double nearest = 0.0;
    for (unsigned chosen = 0; chosen < 1u << best.count; ++chosen) {
      Subset subset{worst, 0, 0};
      int count = 1;
      for (int i = 0; i < best.count; ++i)
        if ((chosen >> i & 1u) != 0u && count < kMostActive)
          subset[static_cast<std::size_t>(count++)] = best.active[static_cast<std::size_t>(i)];
      Vec3 point;
      if (!on_planes(spaces, subset, count, goal, point)) continue;
      bool inside = true;
      for (int i = 0; i < best.count; ++i)
        inside &= spaces[best.active[static_cast<std::size_t>(i)]].height(point) >= -tolerance;
      const double distance = (point - goal).squaredNorm();
      if (!inside || (next.found && distance >= nearest)) continue;
      next = {.point = point, .active = subset, .count = count, .found = true};
      nearest = distance;
    }
    if (!next.found) break;
    best = next;
  }
  best.found = false;
  return best;
}

}  // namespace feltwire
