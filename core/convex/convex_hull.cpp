#include "core/convex/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/convex/hull_triangles.hpp"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace feltwire {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// Owns Qhull's state and always frees it.
class Qhull {
 public:
  explicit Qhull(std::FILE* messages) { qh_zero(&state_, messages); }
  ~Qhull() {
    int left = 0, bytes = 0;
    qh_freeqhull(&state_, !qh_ALL);
    qh_memfreeshort(&state_, &left, &bytes);
  }
  Qhull(const Qhull&) = delete;
  Qhull& operator=(const Qhull&) = delete;
  qhT* get() { return &state_; }

 private:
  qhT state_{};
};

/// Returns true if all points lie in one plane, on one line or at one point, within rounding
/// errors. Qhull has a different error for each of these cases, so this function tests them first.
bool is_flat(std::span<const Vec3> points) {
  constexpr double kFlat = 1e-13;  // tolerance, as a share of the size of the point set
  const auto farthest = [&](const auto& distance) {
    return *std::ranges::max_element(points, {}, distance);
  };
  const Vec3 origin = points[0];
  const Vec3 along = farthest([&](const Vec3& p) { return (p - origin).norm(); }) - origin;
  const double size = along.norm();
  if (!(size > 0.0)) return true;
  const Vec3 axis = along / size;
  const auto off = [&](const Vec3& p) -> Vec3 { return p - origin - axis.dot(p - origin) * axis; };
  const Vec3 beside = off(farthest([&](const Vec3& p) { return off(p).norm(); }));
  if (!(beside.norm() > kFlat * size)) return true;
  const Vec3 normal = axis.cross(beside).normalized();
  const auto height = [&](const Vec3& p) { return std::abs(normal.dot(p - origin)); };
  return !(height(farthest(height)) > kFlat * size);
}

/// Calls read(qh) with the triangulated hull of the points. Returns false if there are fewer than
/// four points or if they lie in a plane.
template <class Read>
bool with_hull(std::span<const Vec3> points, Read read) {
  constexpr std::size_t kLeast = 4;
  if (points.size() < kLeast || is_flat(points)) return false;
  // Drop Qhull's messages about flat points, because they do not help a user.
  const std::unique_ptr<std::FILE, CloseFile> messages(std::fopen("/dev/null", "w"));
  if (messages == nullptr) throw std::runtime_error("convex hull: cannot open /dev/null");
  std::vector<coordT> coordinates;
  coordinates.reserve(3 * points.size());
  for (const Vec3& p : points) coordinates.insert(coordinates.end(), {p.x(), p.y(), p.z()});
  Qhull qhull(messages.get());
  qhT* const qh = qhull.get();
  std::string command = "qhull Qt Pp";
  const int failed = qh_new_qhull(qh, 3, static_cast<int>(points.size()), coordinates.data(), False,
                                  command.data(), nullptr, messages.get());
  if (failed == qh_ERRmem) throw std::bad_alloc();
  if (failed == qh_ERRsingular || failed == qh_ERRprec) return false;
  if (failed != 0)
    throw std::runtime_error("convex hull: Qhull cannot compute it (error " +
                             std::to_string(failed) + ")");
  read(*qh);
  return true;
}

std::size_t index_of(const qhT& qh, const vertexT& vertex) {
  return static_cast<std::size_t>(vertex.point - qh.first_point) / 3;
}

/// Returns the indices of the hull's corners among the given points, in ascending order.
std::vector<std::size_t> corners_of(const qhT& qh) {
  std::vector<std::size_t> corners;
  for (const vertexT* vertex = qh.vertex_list; vertex != nullptr && vertex->next != nullptr;
       vertex = vertex->next)
    corners.push_back(index_of(qh, *vertex));
  std::ranges::sort(corners);
  return corners;
}

/// Calls visit(facet, plane) for each facet.
template <class Visit>
void for_each_facet(const qhT& qh, Visit visit) {
  for (const facetT* facet = qh.facet_list; facet != nullptr && facet->next != nullptr;
       facet = facet->next)
    if (facet->normal != nullptr)
      visit(*facet,
            HalfSpaceBelow{{facet->normal[0], facet->normal[1], facet->normal[2]}, -facet->offset});
}

const vertexT& corner_of(const facetT& facet, int k) {
  return *static_cast<const vertexT*>(facet.vertices->e[k].p);
}

}  // namespace

std::optional<ConvexHull> convex_hull(std::span<const Vec3> points) {
  ConvexHull hull;
  const bool solid = with_hull(points, [&](const qhT& qh) {
    const std::vector<std::size_t> corners = corners_of(qh);
    hull.vertices.reserve(corners.size());
    Vec3 middle = Vec3::Zero();
    for (const std::size_t corner : corners) {
      hull.vertices.push_back(points[corner]);
      middle += points[corner];
    }
    middle /= static_cast<double>(corners.size());
    for_each_facet(qh, [&](const facetT& facet, const HalfSpaceBelow& plane) {
      hull.planes.push_back(plane);
      const auto corner = [&](int k) -> Vec3 {
        const coordT* point = corner_of(facet, k).point;
        return Vec3(point[0], point[1], point[2]) - middle;
      };
      hull.volume += std::abs(corner(0).dot(corner(1).cross(corner(2)))) / 6.0;
    });
  });
  return solid ? std::optional(std::move(hull)) : std::nullopt;
}

HullTriangles hull_triangles(std::span<const Vec3> points) {
  HullTriangles found;
  with_hull(points, [&](const qhT& qh) {
    const std::vector<std::size_t> corners = corners_of(qh);
    double largest = 0.0;
    bool clockwise = false;
    for_each_facet(qh, [&](const facetT& facet, const HalfSpaceBelow& plane) {
      std::array<std::uint32_t, 3> triangle{};
      std::array<Vec3, 3> place;
      for (int k = 0; k < 3; ++k) {
        const std::size_t corner = index_of(qh, corner_of(facet, facet.toporient ? k : 2 - k));
        place[k] = points[corner];
        triangle[k] =
            static_cast<std::uint32_t>(std::ranges::lower_bound(corners, corner) - corners.begin());
      }
      // All triangles have the same orientation. The largest triangle determines the orientation
      // most reliably.
      const Vec3 turn = (place[1] - place[0]).cross(place[2] - place[0]);
      if (turn.norm() > largest) {
        largest = turn.norm();
        clockwise = turn.dot(plane.normal) < 0.0;
      }
      found.corners.push_back(triangle);
      found.planes.push_back(plane);
    });
    if (clockwise)
      for (auto& triangle : found.corners) std::swap(triangle[1], triangle[2]);
  });
  return found;
}

}  // namespace feltwire
