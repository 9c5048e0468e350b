// The proxy of a point on a mesh. Where each edge has two triangles, the proxy walks from triangle
// to neighbour towards the goal. This walk needs no search, so its cost does not depend on the size
// of the mesh. Ray casts and up to three planes handle the other cases: crossing surfaces, edges
// with one triangle or more than two, and the way back into free space.

#include <array>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/geometry/half_spaces.hpp"
#include "core/geometry/segment.hpp"
#include "core/mesh/mesh_contact.hpp"

namespace feltwire {
namespace {

constexpr int kMostPieces = 32;  // largest number of pieces of a path per collision check
constexpr int kMostLegs = 64;    // largest number of collision checks per sample
constexpr int kMostStill = 16;   // largest number of successive steps without a movement
constexpr int kMostRounds = 48;  // largest number of ray casts per sample
// Units of work. The box tree counts its own work.
constexpr std::uint64_t kTriangleWork = 4;  // units per crossed or tested triangle
constexpr std::uint64_t kRoundWork = 8;

std::size_t next(std::size_t k) { return k == 2 ? 0 : k + 1; }
std::size_t previous(std::size_t k) { return k == 0 ? 2 : k - 1; }

/// A triangle, as seen from the proxy's side.
struct Face {
  Face(const MeshSurface& surface, std::uint32_t t, std::int8_t side)
      : corners(surface.mesh().corners(t)),
        outward((corners[1] - corners[0]).cross(corners[2] - corners[0])),
        normal(side * triangle_normal(corners)) {}

  double height(const Vec3& p) const { return normal.dot(p - corners[0]); }
  /// Returns a vector in the plane that is perpendicular to edge k and points out of the triangle.
  /// The vector is not normalised.
  Vec3 out_of(std::size_t k) const { return (corners[next(k)] - corners[k]).cross(outward); }

  std::array<Vec3, 3> corners;
  Vec3 outward;  // normal of the triangle itself, not normalised
  Vec3 normal;   // unit normal on the proxy's side
};

enum class Outcome {
  standing,  // No step reduces the distance to the goal.
  going,     // The path has too many pieces.
  leaving,   // The goal is in front of the surface.
  crowded,   // The walk cannot cross an edge.
};

/// A straight piece of the path, in one triangle.
struct Piece {
  Vec3 from, to;
  std::uint32_t triangle = 0;
};

class Walk {
 public:
  Walk(const MeshSurface& surface, const Vec3& goal, ProxyState& at, WorkLimit* work)
      : surface_(surface), mesh_(surface.mesh()), goal_(goal), at_(at), work_(work) {}

  Outcome run() {
    count_ = 0;
    for (int still = 0; still < kMostStill;) {
      if (count_ + 2 > kMostPieces) return Outcome::going;
      if (!may_go_on(work_, kTriangleWork)) return Outcome::standing;
      const Vec3 before = at_.point;
      const auto outcome = cross_triangle();
      if (outcome) return *outcome;
      still = at_.point == before ? still + 1 : 0;
    }
    return Outcome::standing;
  }
  std::span<const Piece> pieces() const { return {pieces_.data(), count_}; }

 private:
  void go_to(const Vec3& p) {
    pieces_[count_++] = {at_.point, p, at_.triangle};
    at_.point = p;
  }

  /// Goes straight across the triangle, to the projection of the goal or to an edge. Returns
  /// nothing if the walk continues.
  std::optional<Outcome> cross_triangle() {
    const Face face(surface_, at_.triangle, at_.side);
    const double height = face.height(goal_);
    at_.on_face = false;
    const Vec3 target = goal_ - height * face.normal;
    const Vec3 way = target - at_.point;
    std::size_t exit = 3;
    double part = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 out = face.out_of(k);
      const double rate = out.dot(way);
      if (!(rate > 0.0)) continue;
      const double room = std::max(0.0, out.dot(face.corners[k] - at_.point));
      if (!(room < part * rate)) continue;
      part = room / rate;
      exit = k;
    }
    if (height >= 0.0) return leave(face);
    if (exit == 3) {
      go_to(target);
      at_.on_face = true;
      return Outcome::standing;
    }
    // Project the point onto the edge, so that rounding errors do not add up.
    go_to(on_edge(face, exit, at_.point + part * way));
    return cross_edge(face, exit);
  }

  static Vec3 on_edge(const Face& face, std::size_t k, const Vec3& p) {
    return nearest_on_segment(face.corners[k], face.corners[next(k)], p).point;
  }

  /// Handles a goal in front of this triangle. The goal may still be behind a neighbour that the
  /// proxy touches.
  std::optional<Outcome> leave(const Face& face) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double length = (face.corners[next(k)] - face.corners[k]).norm();
      if (!((on_edge(face, k, at_.point) - at_.point).norm() <= kTouching * length)) continue;
      const std::uint32_t other = mesh_.neighbour(at_.triangle, static_cast<int>(k));
      if (other == TriangleMesh::kNone) return Outcome::crowded;
      const Face beyond(surface_, other, at_.side);
      if (!(beyond.height(goal_) < 0.0) || !leads_into(face, k, beyond)) continue;
      at_.triangle = other;
      return std::nullopt;
    }
    return Outcome::leaving;
  }

  /// Returns true if a step into the triangle beyond edge k of `face` reduces the distance to the
  /// goal.
  bool leads_into(const Face& face, std::size_t k, const Face& beyond) const {
    const Vec3 edge = face.corners[next(k)] - face.corners[k];
    // The neighbour lists the edge in the other direction, so this vector points into the
    // neighbour.
    return edge.cross(beyond.outward).dot(goal_ - at_.point) > 0.0;
  }

  std::optional<Outcome> cross_edge(const Face& face, std::size_t k) {
    const std::uint32_t other = mesh_.neighbour(at_.triangle, static_cast<int>(k));
    if (other == TriangleMesh::kNone) return Outcome::crowded;
    const Face beyond(surface_, other, at_.side);
    const bool convex = face.normal.dot(apex(other, at_.triangle) - face.corners[k]) < 0.0;
    if (convex && beyond.height(goal_) >= 0.0) return Outcome::leaving;
    if (leads_into(face, k, beyond)) {
      at_.triangle = other;
      return std::nullopt;
    }
    // Both triangles block the proxy, so the proxy slides along the edge.
    const Vec3 edge = face.corners[next(k)] - face.corners[k];
    const double part = edge.dot(goal_ - face.corners[k]) / edge.squaredNorm();
    if (part > 0.0 && part < 1.0) {
      go_to(face.corners[k] + part * edge);
      return Outcome::standing;
    }
    const std::size_t corner = part >= 1.0 ? next(k) : k;
    go_to(face.corners[corner]);
    return cross_corner(mesh_.triangles()[at_.triangle][corner]);
  }

  /// Returns the corner of triangle t that `other` does not share.
  Vec3 apex(std::uint32_t t, std::uint32_t other) const {
    const Triangle& mine = mesh_.triangles()[t];
    const Triangle& others = mesh_.triangles()[other];
    for (const std::uint32_t v : mine)
      if (v != others[0] && v != others[1] && v != others[2]) return mesh_.vertices()[v];
    return mesh_.vertices()[mine[0]];
  }

  /// Enters the triangle around this corner in which the distance to the goal falls fastest.
  std::optional<Outcome> cross_corner(std::uint32_t vertex) {
    const Vec3 d = goal_ - at_.point;
    double steepest = 0.0;
    std::uint32_t best = at_.triangle;
    Vec3 mean = Vec3::Zero();
    for (const std::uint32_t t : mesh_.around(vertex)) {
      if (!may_go_on(work_, kTriangleWork)) return Outcome::standing;
      const Triangle& corner = mesh_.triangles()[t];
      const std::size_t k = corner[0] == vertex ? 0 : corner[1] == vertex ? 1 : 2;
      if (mesh_.neighbour(t, static_cast<int>(k)) == TriangleMesh::kNone ||
          mesh_.neighbour(t, static_cast<int>(previous(k))) == TriangleMesh::kNone)
        return Outcome::crowded;
      const Face face(surface_, t, at_.side);
      const Vec3 u = direction(Vec3(face.corners[next(k)] - at_.point));
      const Vec3 w = direction(Vec3(face.corners[previous(k)] - at_.point));
      mean += std::atan2(u.cross(w).norm(), u.dot(w)) * face.normal;
      const Vec3 flat = d - along(d, face.normal);
      const bool within =
          u.cross(flat).dot(face.outward) > 0.0 && flat.cross(w).dot(face.outward) > 0.0;
      const double fall = within ? length(flat) : std::max(u.dot(d), w.dot(d));
      if (!(fall > steepest)) continue;
      steepest = fall;
      best = t;
    }
    // Ignore a step below the rounding error of the goal.
    if (!(steepest > kTouching * length(d)))
      return mean.dot(d) < 0.0 ? Outcome::standing : Outcome::leaving;
    at_.triangle = best;
    return std::nullopt;
  }

  static constexpr double kTouching = 1e-12;  // tolerance, as a share of an edge

  const MeshSurface& surface_;
  const TriangleMesh& mesh_;
  const Vec3& goal_;
  ProxyState& at_;
  WorkLimit* work_;
  std::array<Piece, kMostPieces> pieces_;
  std::size_t count_ = 0;
};

bool have_common_corner(const Triangle& a, const Triangle& b) {
  for (const std::uint32_t i : a)
    for (const std::uint32_t j : b)
      if (i == j) return true;
  return false;
}

/// Returns true if the path crosses another part of the mesh: a triangle that is no neighbour of
/// the path's triangles.
bool is_barred(const MeshSurface& surface, std::int8_t sides, std::span<const Piece> pieces,
               WorkLimit* work) {
  Bounds box;
  for (const Piece& piece : pieces) {
    box.add(piece.from);
    box.add(piece.to);
  }
  bool barred = false;
  const auto& triangles = surface.mesh().triangles();
  surface.tree().overlapping(
      box,
      [&](std::uint32_t t) {
        if (!may_go_on(work, pieces.size())) return;
        for (const Piece& piece : pieces)
          barred =
              barred || (t != piece.triangle && surface.crossing(t, piece.from, piece.to, sides) &&
                         !have_common_corner(triangles[t], triangles[piece.triangle]));
      },
      work);
  return barred;
}

/// A plane that holds the proxy one skin (a collision margin) in front of a triangle.
struct HoldingPlane {
  Face face;
  std::uint32_t triangle;
  std::int8_t side;
};

/// Returns true if the projection of p lies in the triangle. At an edge without a neighbour, the
/// triangle is extended by one skin.
bool is_over(const MeshSurface& surface, const HoldingPlane& held, const Vec3& p) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 out = held.face.out_of(k);
    const bool ends =
        surface.mesh().neighbour(held.triangle, static_cast<int>(k)) == TriangleMesh::kNone;
    if (out.dot(p - held.face.corners[k]) > (ends ? surface.skin() * length(out) : 0.0))
      return false;
  }
  return true;
}

/// Returns the proxy's point, moved in front of its triangle and of the neighbours that it touches.
Vec3 lifted(const MeshSurface& surface, const ProxyState& proxy) {
  const Face face(surface, proxy.triangle, proxy.side);
  Vec3 up = face.normal;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t other = surface.mesh().neighbour(proxy.triangle, static_cast<int>(k));
    const Vec3 out = face.out_of(k);
    if (other == TriangleMesh::kNone ||
        out.dot(face.corners[k] - proxy.point) > surface.skin() * length(out))
      continue;
    up += Face(surface, other, proxy.side).normal;
  }
  return proxy.point + surface.skin() * direction(up);
}

/// Moves the proxy from a point in free space by ray casts and planes (Zilles & Salisbury).
void move_by_rays(const MeshSurface& surface, std::int8_t sides, const Vec3& goal,
                  ProxyState& proxy, WorkLimit* work) {
  const double skin = surface.skin();
  std::array<std::optional<HoldingPlane>, 3> held;
  std::size_t count = 0;
  Vec3 at = proxy.point;
  for (int round = 0; round < kMostRounds && may_go_on(work, kRoundWork); ++round) {
    std::array<HalfSpace, 3> spaces;
    for (std::size_t i = 0; i < count; ++i)
      spaces[i] = {held[i]->face.normal, held[i]->face.normal.dot(held[i]->face.corners[0]) + skin};
    const NearestPoint aim = nearest_in({spaces.data(), count}, goal, 0.25 * skin);
    if (!aim.found) break;
    const auto hit = surface.first_crossing(at, aim.point, sides, work);
    if (hit) {
      const Face face(surface, hit->triangle, hit->side);
      const Vec3 way = aim.point - at;
      const double from = face.height(at), fall = -face.normal.dot(way);
      at += std::clamp((from - skin) / fall, 0.0, hit->part) * way;
      bool known = false;
      for (std::size_t i = 0; i < count; ++i) known = known || held[i]->triangle == hit->triangle;
      if (known || count == held.size()) break;  // The planes hold the proxy here.
      held[count++].emplace(HoldingPlane{face, hit->triangle, hit->side});
      continue;
    }
    at = aim.point;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i)
      if (is_over(surface, *held[i], at) && held[i]->face.height(goal) < skin)
        held[kept++] = held[i];
    const bool done = kept == count;
    count = kept;
    if (done) break;
  }
  if (count == 0) {
    proxy = {.point = at, .triangle = 0, .side = 0, .on_face = false};
    return;
  }
  const HoldingPlane& first = *held[0];
  proxy = {.point = at, .triangle = first.triangle, .side = first.side, .on_face = false};
  if (count > 1) return;
  const double height = first.face.height(goal);
  const Vec3 below = goal - height * first.face.normal;
  if (height >= 0.0 || !is_over(surface, first, below)) return;
  proxy.point = below;
  proxy.on_face = true;
}

}  // namespace

void move_point(const MeshSurface& surface, std::int8_t sides, const Vec3& goal, ProxyState& proxy,
                WorkLimit* work) noexcept {
  if (proxy.side == 0) {
    const auto hit = surface.first_crossing(proxy.point, goal, sides, work);
    if (!hit) {
      proxy.point = goal;
      return;
    }
    proxy = {.point = proxy.point + hit->part * (goal - proxy.point),
             .triangle = hit->triangle,
             .side = hit->side,
             .on_face = false};
  }
  Walk walk(surface, goal, proxy, work);
  for (int leg = 0; leg < kMostLegs && !is_cut(work); ++leg) {
    const ProxyState before = proxy;
    Outcome outcome = walk.run();
    if (is_barred(surface, sides, walk.pieces(), work)) {
      proxy = before;
      outcome = Outcome::crowded;
    }
    if (outcome == Outcome::going) continue;
    if (outcome != Outcome::standing) {
      proxy.point = lifted(surface, proxy);
      move_by_rays(surface, sides, goal, proxy, work);
    }
    return;
  }
}

}  // namespace feltwire
