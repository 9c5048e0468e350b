// The proxy of a ball on a mesh. The centre of the ball moves towards the goal and stays at least
// one radius away from all triangles. Each step is shorter than half a radius and ends only at a
// point with this clearance. So the centre never passes through a surface. Within a step,
// sequential quadratic programming linearises the distances to the triangles in contact.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/geometry/half_spaces.hpp"
#include "core/mesh/mesh_contact.hpp"

namespace feltwire {
namespace {

constexpr int kMostSteps = 256;         // largest number of steps per sample
constexpr int kMostCorrections = 16;    // largest number of iterations per step
constexpr std::size_t kMostNear = 512;  // largest number of triangles near a step
constexpr std::size_t kMostHeld = 16;
constexpr double kExact = 1e-7;  // accuracy of positions, as a share of the radius
// First and largest step length, as a share of the radius.
constexpr double kFirstReach = 0.125, kMostReach = 0.5;
constexpr double kLeastReach = 0x1p-16;
constexpr double kFarther = 1.25;           // search range, in step lengths
constexpr double kTolerance = 0.1;          // tolerance of the planes, as a share of exact_
constexpr std::size_t kTangentsInUnit = 8;  // number of tangents per unit of work

class Ball {
 public:
  Ball(const MeshSurface& surface, double radius, std::int8_t sides, const Vec3& goal,
       ProxyState& proxy, WorkLimit* work)
      : surface_(surface),
        mesh_(surface.mesh()),
        radius_(radius),
        exact_(kExact * radius_),
        sides_(sides),
        goal_(goal),
        stand_(proxy),
        work_(work) {}

  void run() {
    double reach = kFirstReach * radius_;
    for (int step = 0; step < kMostSteps && may_go_on(work_); ++step) {
      const double left = length(Vec3(goal_ - stand_.point));
      if (!(left > 0.0) || (step == 0 && stand_.side == 0 && is_open())) return arrive();
      reach = std::min(reach, kMostReach * radius_);
      while (!gather(reach))
        if (is_cut(work_) || (reach *= 0.5) < kLeastReach * radius_)
          return;  // The ball stays, because there are too many triangles.
      const Vec3 before = stand_.point;
      const bool whole = move(std::min(reach, left));
      const double moved = length(Vec3(stand_.point - before));
      if (held_count_ == 0 && stand_.point == goal_) return arrive();
      if (!whole || !(moved > exact_)) return;
      reach *= 2.0;
    }
  }

 private:
  void arrive() { stand_ = {.point = goal_, .triangle = 0, .side = 0, .on_face = false}; }

  /// Returns true if no triangle is within one radius of the bounding box of the movement.
  bool is_open() const {
    Bounds way;
    way.add(stand_.point);
    way.add(goal_);
    bool open = true;
    surface_.tree().overlapping(
        way.grown(radius_), [&](std::uint32_t) { open = false; }, work_);
    return open;
  }

  bool is_felt(std::uint32_t t) const {
    if (sides_ == 0) return true;
    const std::array<Vec3, 3> c = mesh_.corners(t);
    return sides_ * (c[1] - c[0]).cross(c[2] - c[0]).dot(stand_.point - c[0]) > 0.0;
  }

  /// Collects all triangles that may be nearer than one radius during a step of length `reach`.
  /// Returns false if there are too many.
  bool gather(double reach) {
    near_count_ = 0;
    held_count_ = 0;
    least_ = radius_;
    bool fits = true;
    const double far = radius_ + kFarther * reach;
    surface_.tree().within(
        stand_.point, [&] { return far; },
        [&](std::uint32_t t) {
          const Vec3 away = stand_.point - nearest_on(t, stand_.point);
          const double distance = away.norm();
          if (distance > far || !is_felt(t)) return;
          if (near_count_ == kMostNear) {
            fits = false;
            return;
          }
          near_[near_count_++] = {t, distance,
                                  distance > 0.0 ? Vec3(away / distance) : Vec3::Zero()};
          least_ = std::min(least_, distance);
          if (distance <= radius_ + exact_) hold(t);
        },
        work_);
    return fits && !is_cut(work_);
  }

  Vec3 nearest_on(std::uint32_t t, const Vec3& p) const {
    return nearest_on_triangle(mesh_.corners(t), p).point;
  }

  void hold(std::uint32_t t) {
    if (held_count_ < kMostHeld) held_[held_count_++] = t;
  }

  /// Linearises the distance to each triangle in contact at x. Each plane keeps the centre one
  /// radius away from its triangle.
  std::size_t linearise(const Vec3& x, std::array<HalfSpace, kMostHeld>& spaces) const {
    std::size_t count = 0;
    if (!may_go_on(work_, held_count_)) return count;
    for (std::size_t i = 0; i < held_count_; ++i) {
      const Vec3 q = nearest_on(held_[i], x);
      const Vec3 n = direction(Vec3(x - q));
      if (!n.isZero(0.0)) spaces[count++] = {n, n.dot(q) + radius_};
    }
    return count;
  }

  /// Returns the distance [m] from x to the nearest triangle. The distance to a triangle is a
  /// convex function, so its tangent at the start of the step is a lower bound. The triangle with
  /// the lowest bound is queried first. Most other triangles then need no query.
  double least_distance(const Vec3& x, std::uint32_t& nearest) const {
    double least = std::numeric_limits<double>::infinity();
    if (near_count_ == 0 || !may_go_on(work_, 1 + near_count_ / kTangentsInUnit)) return least;
    const Vec3 moved = x - stand_.point;
    std::array<double, kMostNear> tangents;
    std::size_t first = 0;
    for (std::size_t i = 0; i < near_count_; ++i) {
      tangents[i] = near_[i].distance + near_[i].away.dot(moved);
      if (tangents[i] < tangents[first]) first = i;
    }
    const auto ask = [&](const NearbyTriangle& near) {
      const double distance = (x - nearest_on(near.triangle, x)).norm();
      if (!(distance < least)) return;
      least = distance;
      nearest = near.triangle;
    };
    ask(near_[first]);
    for (std::size_t i = 0; i < near_count_; ++i) {
      if (!(tangents[i] < least) || i == first) continue;
      if (!may_go_on(work_)) break;
      ask(near_[i]);
    }
    return least;
  }

  /// Makes a step. Returns true if the step converged and reached its largest length.
  bool move(double reach) {
    const Vec3 from = stand_.point;
    Vec3 x = from;
    bool cut = false, settled = false;
    std::uint32_t nearest = 0;
    for (int i = 0; i < kMostCorrections && !settled && !is_cut(work_); ++i) {
      std::array<HalfSpace, kMostHeld> spaces;
      const std::size_t count = linearise(x, spaces);
      const std::span<const HalfSpace> planes(spaces.data(), count);
      const NearestPoint aim = nearest_in(planes, goal_, kTolerance * exact_, work_);
      const Vec3 way = aim.point - from;
      const double far = length(way);
      cut = far > reach;
      // A shortened step may violate the planes, so project it onto them. The projection moves the
      // end by less than the search margin of gather().
      Vec3 next = aim.point;
      if (cut)
        next = nearest_in(planes, from + reach / far * way, kTolerance * exact_, work_).point;
      const bool still = length(Vec3(next - x)) <= exact_;
      x = next;
      if (length(Vec3(x - from)) > kFarther * reach) break;
      if (least_distance(x, nearest) < std::min(radius_, least_) - exact_) {
        if (std::find(held_.begin(), held_.begin() + held_count_, nearest) ==
            held_.begin() + held_count_)
          hold(nearest);
        continue;
      }
      settled = still || (held_count_ == 0) || cut;
    }
    if (!settled) x = last_clear(from, x, kFarther * reach);
    proxy(x);
    stand_.point = x;
    return cut && settled;
  }

  /// Returns the end of the movement from `from` to `x`. Halves the movement until its end is far
  /// enough from all triangles.
  Vec3 last_clear(const Vec3& from, const Vec3& x, double most) const {
    constexpr int kMostHalvings = 12;
    std::uint32_t nearest = 0;
    Vec3 way = x - from;
    const double far = length(way);
    if (far > most) way *= most / far;
    for (int i = 0; i < kMostHalvings && !is_cut(work_); ++i, way *= 0.5)
      if (least_distance(from + way, nearest) >= std::min(radius_, least_) - exact_)
        return from + way;
    return from;
  }

  void proxy(const Vec3& x) {
    if (x == goal_) return;
    std::uint32_t nearest = stand_.triangle;
    least_distance(x, nearest);
    const std::array<Vec3, 3> c = mesh_.corners(nearest);
    stand_.triangle = nearest;
    stand_.side = (c[1] - c[0]).cross(c[2] - c[0]).dot(x - c[0]) < 0.0 ? -1 : 1;
    if (sides_ != 0) stand_.side = sides_;
  }

  const MeshSurface& surface_;
  const TriangleMesh& mesh_;
  const double radius_, exact_;  // [m] radius of the ball, accuracy of positions
  const std::int8_t sides_;
  const Vec3& goal_;
  ProxyState& stand_;
  WorkLimit* work_;
  struct NearbyTriangle {
    std::uint32_t triangle;
    double distance;  // [m] distance to the triangle at the start of the step
    Vec3 away;        // unit vector from the triangle to the start
  };
  std::array<NearbyTriangle, kMostNear> near_;
  std::array<std::uint32_t, kMostHeld> held_;
  std::size_t near_count_ = 0, held_count_ = 0;
  double least_ = 0.0;  // [m] clearance at the start of the step, at most the radius
};

}  // namespace

void move_ball(const MeshSurface& surface, double radius, std::int8_t sides, const Vec3& goal,
               ProxyState& proxy, WorkLimit* work) noexcept {
  Ball(surface, radius, sides, goal, proxy, work).run();
}

}  // namespace feltwire
