#include "core/mesh/mesh_distance.hpp"

#include <embree3/rtcore.h>
#include <sys/types.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/base/numeric.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kCorners = 3;

struct DeviceRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

double angle_at(const std::array<Vec3, 3>& c, std::size_t corner) {
  const Vec3 a = c[corner_after(corner)] - c[corner],
             b = c[corner_after(corner_after(corner))] - c[corner];
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

void require_solid(const MeshReport& report) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("mesh: " + what); };
  const auto edges = [](std::size_t n) {
    return std::to_string(n) + (n == 1 ? " edge" : " edges");
  };
  if (report.boundary_edges > 0)
    refuse("is open at " + edges(report.boundary_edges) +
           ", so that nothing is inside; close the holes");
  if (report.non_manifold_edges > 0)
    refuse("has more than two triangles at " + edges(report.non_manifold_edges) +
           ", so that inside and outside are not told apart; take its solids apart");
  if (report.turned_edges > 0)
    refuse("has triangles that disagree about the outside at " + edges(report.turned_edges) +
           "; orient them alike");
  if (!(report.volume > 0.0))
    refuse("is inside out: it encloses a negative volume; turn its triangles round");
}

bool count_bytes(void* counter, ssize_t bytes, bool) {
  static_cast<std::atomic<ssize_t>*>(counter)->fetch_add(bytes);
  return true;
}

class MeshDistance {
 public:
  explicit MeshDistance(const TriangleMesh& mesh);
  FieldPoint at(const Vec3& position) const;
  std::size_t bytes() const;

 private:
  struct Search {
    const MeshDistance* mesh = nullptr;
    Vec3 position;
    double squared = std::numeric_limits<double>::infinity();
    Vec3 way = Vec3::Zero();
    std::uint32_t triangle = 0;
    std::size_t part = 0;  // of it, as in NearestOnTriangle
  };
  static bool visit(RTCPointQueryFunctionArguments* arguments);
  void build_tree();
  Vec3 pseudo_normal(std::uint32_t t, std::size_t part) const;
  std::array<Vec3, 3> corners(std::uint32_t t) const {
    const Triangle& c = triangles_[t];
    return {vertices_[c[0]], vertices_[c[1]], vertices_[c[2]]};
  }

  Vec3 origin_;
  float rounding_ = 0.0F;       // [m] that the tree's coordinates may be off, and the query's
  std::vector<Vec3> vertices_;  // [m] from the origin
  std::vector<Triangle> triangles_;
  std::vector<Vec3> normals_, corner_normals_;
  std::vector<std::array<Vec3, 3>> edge_normals_;  // of edge k, from corner k to corner k + 1
  std::atomic<ssize_t> tree_bytes_ = 0;  // by Embree's own account; it outlives the device
  std::unique_ptr<RTCDeviceTy, DeviceRelease> device_;
  std::unique_ptr<RTCSceneTy, SceneRelease> tree_;
};

MeshDistance::MeshDistance(const TriangleMesh& mesh)
    : origin_(mesh.origin()), vertices_(mesh.vertices()), triangles_(mesh.triangles()) {
  require_solid(mesh.report());
  const auto count = static_cast<std::uint32_t>(triangles_.size());
  corner_normals_.assign(vertices_.size(), Vec3::Zero());
  for (std::uint32_t t = 0; t < count; ++t) {
    const auto c = corners(t);
    normals_.push_back(triangle_normal(c));
    for (std::size_t k = 0; k < kCorners; ++k)
      corner_normals_[triangles_[t][k]] += angle_at(c, k) * normals_.back();
  }
  edge_normals_.resize(count);
  for (std::uint32_t t = 0; t < count; ++t)
    for (std::size_t k = 0; k < kCorners; ++k)
      edge_normals_[t][k] = normals_[t] + normals_[mesh.neighbour(t, static_cast<int>(k))];
  constexpr float kRounding = 4e-7F;  // a few units in float's last place
  rounding_ = kRounding * static_cast<float>(mesh.half_extents().norm());
  build_tree();
}

void MeshDistance::build_tree() {
  device_.reset(rtcNewDevice(nullptr));
  if (!device_) throw std::runtime_error("Embree does not start; is its library whole?");
  rtcSetDeviceMemoryMonitorFunction(device_.get(), &count_bytes, &tree_bytes_);
  tree_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(tree_.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              kCorners * sizeof(float), vertices_.size()));
  auto* triangles = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle), triangles_.size()));
  if (vertices == nullptr || triangles == nullptr) {
    rtcReleaseGeometry(geometry);
    throw std::runtime_error("Embree has no memory for the mesh; simplify it");
  }
  for (const Vec3& v : vertices_)
    for (const double x : v) *vertices++ = static_cast<float>(x);
  for (const Triangle& t : triangles_)
    for (const std::uint32_t i : t) *triangles++ = i;
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(tree_.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(tree_.get());
  if (rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree could not build a tree over the mesh");
}

Vec3 MeshDistance::pseudo_normal(std::uint32_t t, std::size_t part) const {
  if (part == 0) return normals_[t];
  return part <= kCorners ? edge_normals_[t][part - 1]
                          : corner_normals_[triangles_[t][part - 1 - kCorners]];
}

bool MeshDistance::visit(RTCPointQueryFunctionArguments* arguments) {
  Search& search = *static_cast<Search*>(arguments->userPtr);
  const std::uint32_t t = arguments->primID;
  const NearestOnTriangle found = nearest_on_triangle(search.mesh->corners(t), search.position);
  const Vec3 way = search.position - found.point;
  const double squared = way.squaredNorm();
  // Of equals the first triangle, whatever the order of the tree.
  if (squared > search.squared || (squared == search.squared && t > search.triangle)) return false;
  search.squared = squared;
  search.way = way;
  search.triangle = t;
  search.part = found.part;
  constexpr float kUp = 1.0F + 1e-6F;
  const float radius = kUp * static_cast<float>(std::sqrt(squared)) + search.mesh->rounding_;
  if (!(radius < arguments->query->radius)) return false;
  arguments->query->radius = radius;
  return true;
}

std::size_t MeshDistance::bytes() const {
  const auto size = [](const auto& list) { return list.size() * sizeof list[0]; };
  return sizeof *this + size(vertices_) + size(triangles_) + size(normals_) +
         size(corner_normals_) + size(edge_normals_) + static_cast<std::size_t>(tree_bytes_.load());
}

FieldPoint MeshDistance::at(const Vec3& position) const {
  Search search;
  search.mesh = this;
  search.position = position - origin_;
  RTCPointQuery query{};
  query.x = static_cast<float>(search.position.x());
  query.y = static_cast<float>(search.position.y());
  query.z = static_cast<float>(search.position.z());
  query.radius = std::numeric_limits<float>::infinity();
  RTCPointQueryContext context{};
  rtcInitPointQueryContext(&context);
  rtcPointQuery(tree_.get(), &query, &context, &MeshDistance::visit, &search);
  const double distance = std::sqrt(search.squared);
  const Vec3 pseudo = pseudo_normal(search.triangle, search.part);
  const double sign = search.way.dot(pseudo) < 0.0 ? -1.0 : 1.0;
  return {sign * distance, distance > 0.0 ? Vec3(sign / distance * search.way) : direction(pseudo)};
}

}  // namespace

Solid solid_of(const TriangleMesh& mesh) {
  const auto distance = std::make_shared<const MeshDistance>(mesh);
  return {mesh.origin() - mesh.half_extents(), mesh.origin() + mesh.half_extents(),
          [distance](const Vec3& position) { return distance->at(position).distance; }};
}

MeshField field_of(const TriangleMesh& mesh) {
  const auto distance = std::make_shared<const MeshDistance>(mesh);
  return {[distance](const Vec3& position) { return distance->at(position); }, distance->bytes()};
}

}  // namespace feltwire
