#include "core/convex/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace feltwire {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

/// Qhull's state, freed however the work ends.
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

/// Whether all points lie in one plane, on a line or at one place, to rounding: Qhull has an error
/// of its own for each of these, one of them "internal".
bool is_flat(std::span<const Vec3> points) {
  constexpr double kFlat = 1e-13;  // of the size
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

}  // namespace

std::optional<ConvexHull> convex_hull(std::span<const Vec3> points) {
  constexpr std::size_t kLeast = 4;
  if (points.size() < kLeast || is_flat(points)) return std::nullopt;
  // What Qhull says of flat points is of no use to anybody.
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
  if (failed == qh_ERRsingular || failed == qh_ERRprec) return std::nullopt;
  if (failed != 0)
    throw std::runtime_error("convex hull: Qhull cannot compute it (error " +
                             std::to_string(failed) + ")");

  ConvexHull hull;
  std::vector<std::size_t> corners;
  for (const vertexT* vertex = qh->vertex_list; vertex != nullptr && vertex->next != nullptr;
       vertex = vertex->next)
    corners.push_back(static_cast<std::size_t>(vertex->point - qh->first_point) / 3);
  std::ranges::sort(corners);
  hull.vertices.reserve(corners.size());
  Vec3 middle = Vec3::Zero();
  for (const std::size_t corner : corners) {
    hull.vertices.push_back(points[corner]);
    middle += points[corner];
  }
  middle /= static_cast<double>(corners.size());
  for (const facetT* facet = qh->facet_list; facet != nullptr && facet->next != nullptr;
       facet = facet->next) {
    if (facet->normal == nullptr) continue;
    hull.planes.push_back({{facet->normal[0], facet->normal[1], facet->normal[2]}, -facet->offset});
    const auto corner = [&](int k) -> Vec3 {
      const auto* vertex = static_cast<const vertexT*>(facet->vertices->e[k].p);
      return Vec3(vertex->point[0], vertex->point[1], vertex->point[2]) - middle;
    };
    hull.volume += std::abs(corner(0).dot(corner(1).cross(corner(2)))) / 6.0;
  }
  return hull;
}

}  // namespace feltwire
