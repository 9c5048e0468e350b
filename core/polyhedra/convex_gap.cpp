#include "core/polyhedra/convex_gap.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>

namespace feltwire {
namespace {

const Vec3& support(const Polyhedron& solid, const Vec3& direction) {
  double least = std::numeric_limits<double>::infinity();
  std::size_t at = 0;
  for (std::size_t v = 0; v < solid.vertices.size(); ++v) {
    const double along = direction.dot(solid.vertices[v]);
    if (!(along < least)) continue;
    least = along;
    at = v;
  }
  return solid.vertices[at];
}

/// Up to four points of the Minkowski difference of the solids a and b.
struct Simplex {
  std::array<Vec3, 4> points;
  std::array<Vec3, 4> on_b;  // point of b in each difference
  std::size_t count = 0;

  /// Returns the point of the simplex nearest to the origin. Keeps only the corners of the face
  /// that contains this point.
  Vec3 reduce() {
    double best = std::numeric_limits<double>::infinity();
    Vec3 nearest = points[0];
    unsigned kept = 1;
    for (unsigned set = 1; set < (1U << count); ++set) {
      Vec3 at;
      if (!project(set, at)) continue;
      const double squared = at.squaredNorm();
      if (!(squared < best)) continue;
      best = squared;
      nearest = at;
      kept = set;
    }
    std::size_t left = 0;
    for (std::size_t i = 0; i < count; ++i)
      if ((kept >> i & 1U) != 0) {
        on_b[left] = on_b[i];
        points[left++] = points[i];
      }
    count = left;
    return nearest;
  }

  /// Returns the point of b that is also a point of a. Precondition: the origin is inside the
  /// tetrahedron of the four points.
  Vec3 shared() const {
    Mat3 edges;
    edges << points[1] - points[0], points[2] - points[0], points[3] - points[0];
    const Vec3 part = edges.inverse() * -points[0];
    return (1.0 - part.sum()) * on_b[0] + part[0] * on_b[1] + part[1] * on_b[2] + part[2] * on_b[3];
  }

 private:
  /// Projects the origin on the affine hull of a set of corners. Returns false if the projection is
  /// not between the corners.
  bool project(unsigned set, Vec3& at) const {
    std::array<Vec3, 4> p;
    p.fill(points[0]);
    std::size_t n = 0;
    for (std::size_t i = 0; i < count; ++i)
      if ((set >> i & 1U) != 0) p[n++] = points[i];
    if (n == 1) {
      at = p[0];
      return true;
    }
    const Vec3 a = p[1] - p[0];
    if (n == 2) {
      const double part = -p[0].dot(a) / a.squaredNorm();
      at = p[0] + part * a;
      return part > 0.0 && part < 1.0;
    }
    const Vec3 b = p[2] - p[0];
    if (n == 3) {
      const Vec3 normal = a.cross(b);
      const double area = normal.squaredNorm();
      const double u = -p[0].cross(b).dot(normal) / area, v = -a.cross(p[0]).dot(normal) / area;
      at = p[0] + u * a + v * b;
      return u > 0.0 && v > 0.0 && u + v < 1.0;
    }
    const Vec3 c = p[3] - p[0];
    const double volume = a.dot(b.cross(c));
    const double u = -p[0].dot(b.cross(c)) / volume, v = -a.dot(p[0].cross(c)) / volume,
                 w = -a.dot(b.cross(p[0])) / volume;
    at = Vec3::Zero();
    return u > 0.0 && v > 0.0 && w > 0.0 && u + v + w < 1.0;
  }
};

}  // namespace

double least_along(const Polyhedron& solid, const Vec3& direction) noexcept {
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& v : solid.vertices) least = std::min(least, direction.dot(v));
  return least;
}

ConvexGap convex_gap(const Polyhedron& a, const Mat3& rotation, const Vec3& position,
                     const Polyhedron& b, const Vec3& guess) noexcept {
  constexpr double kClose = 1e-6;
  ConvexGap gap;
  gap.distance = -std::numeric_limits<double>::infinity();
  Vec3 towards = guess;
  Simplex simplex;
  for (int round = 0; round < kGapRounds; ++round) {
    const double length = towards.norm();
    if (!(length > 0.0)) {  // The difference contains the origin.
      if (simplex.count == simplex.points.size()) gap.shared = simplex.shared();
      break;
    }
    const Vec3 away = towards / length;
    const Vec3& on_b = support(b, -away);
    const Vec3 point = rotation * support(a, rotation.transpose() * away) + position - on_b;
    const double extent = away.dot(point);
    if (extent > gap.distance) {
      gap.away = away;
      gap.distance = extent;
    }
    // The true distance is between gap.distance and length. Stop when these are close.
    if (round > 0 && length - gap.distance <= kClose * length) break;
    bool known = false;
    for (std::size_t i = 0; i < simplex.count; ++i) known |= simplex.points[i] == point;
    if (known) break;
    if (simplex.count == simplex.points.size()) break;
    simplex.on_b[simplex.count] = on_b;
    simplex.points[simplex.count++] = point;
    towards = simplex.reduce();
  }
  return gap;
}

}  // namespace feltwire
