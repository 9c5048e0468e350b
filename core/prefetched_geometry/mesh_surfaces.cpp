#include "core/prefetched_geometry/mesh_surfaces.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/mesh/mesh_surface.hpp"
#include "core/prefetched_geometry/trial_ways.hpp"

namespace feltwire {
namespace {

const MeshSurface* mesh_of(const Object& object) {
  const auto* mesh = std::get_if<Mesh>(&object.shape);
  return mesh != nullptr ? mesh->surface.get() : nullptr;
}

MeshOptions options_of(const SurfaceData& data) {
  return {.double_sided = data.double_sided,
          .smooth = data.smooth,
          .radius = data.radius,
          .grain = {.amplitude = data.grain, .wavelength = data.grain_wavelength}};
}

Object object_of(const SurfaceData& data) {
  TriangleSoup soup{data.vertices, data.triangles};
  for (Vec3& vertex : soup.vertices) vertex += data.origin;
  TriangleMesh mesh(soup, 0.0);
  if (mesh.triangles().size() != data.triangles.size())
    throw std::invalid_argument("the surface of object " + std::to_string(data.object) +
                                " has triangles without an area, or twice");
  Object object;
  object.shape = Mesh{std::make_shared<MeshSurface>(std::move(mesh), options_of(data))};
  object.felt_from = data.from_inside ? Side::inside : Side::outside;
  object.pose = data.pose;
  return object;
}

class MeshSurfaces final : public PrefetchedSurfaces {
 public:
  MeshSurfaces(std::uint32_t version, const std::vector<SurfaceData>& surfaces)
      : version_(version) {
    for (const SurfaceData& data : surfaces) {
      if (data.object >= places_.size()) places_.resize(std::size_t{data.object} + 1, kNone);
      places_[data.object] = objects_.size();
      objects_.push_back(object_of(data));
    }
  }

  std::uint32_t version() const noexcept override { return version_; }
  bool has(std::uint16_t object) const noexcept override {
    return object < places_.size() && places_[object] != kNone;
  }
  Command touch(std::uint16_t object, const Material& material, const Tool& tool,
                ContactMemory& memory, WorkLimit* work) const noexcept override {
    Command command;
    feltwire::touch(at(object), material, tool, memory, 0.0, command.elastic, command.frictional,
                    work);
    return command;
  }
  ContactMemory memory_of(const SurfacePatch& patch, const Vec3& tool,
                          WorkLimit* work) const noexcept override;
  std::vector<TrialWay> trial_ways() const override;

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  const Object& at(std::uint16_t object) const noexcept { return objects_[places_[object]]; }

  std::uint32_t version_;
  std::vector<std::size_t> places_;  // index in objects_, by object number
  std::vector<Object> objects_;
};

ContactMemory MeshSurfaces::memory_of(const SurfacePatch& patch, const Vec3& tool,
                                      WorkLimit* work) const noexcept {
  const Object& object = at(patch.object);
  const MeshSurface& surface = *mesh_of(object);
  const Quaternion to_object = object.pose.orientation.conjugate();
  const auto in_object = [&](const Vec3& p) {
    return Vec3(to_object * (p - object.pose.position));
  };
  ContactMemory memory;
  approach_from(object.shape, in_object(tool), memory.feature);
  if (!patch.touching) return memory;
  const Vec3 point = in_object(patch.point) - surface.mesh().origin();
  const Vec3 normal = to_object * patch.normal;
  const auto nearest = surface.nearest(point, std::numeric_limits<double>::infinity(), work);
  const bool front = triangle_normal(surface.mesh().corners(nearest.triangle)).dot(normal) >= 0.0;
  memory.touching = true;
  memory.slipping = patch.slipping;
  memory.anchor = in_object(patch.anchor);
  memory.feature.feature = 1;
  memory.feature.normal = normal;
  memory.feature.triangle = nearest.triangle;
  memory.feature.side = front ? std::int8_t{1} : std::int8_t{-1};
  memory.feature.proxy = nearest.point + surface.options().radius * normal;
  return memory;
}

std::vector<TrialWay> MeshSurfaces::trial_ways() const {
  std::vector<TrialWay> all;
  for (std::size_t index = 0; index < places_.size(); ++index) {
    if (places_[index] == kNone) continue;
    const std::vector<TrialWay> ways =
        mesh_ways(objects_[places_[index]], static_cast<std::uint16_t>(index));
    all.insert(all.end(), ways.begin(), ways.end());
  }
  return all;
}

}  // namespace

bool can_travel(const Object& object) noexcept {
  const MeshSurface* mesh = mesh_of(object);
  return mesh != nullptr && mesh->options().height_map == nullptr;
}

std::optional<SurfaceData> surface_data(const Object& object, std::uint16_t index, double ball) {
  if (!can_travel(object)) return std::nullopt;
  const MeshSurface& mesh = *mesh_of(object);
  const MeshOptions& options = mesh.options();
  return SurfaceData{.object = index,
                     .pose = object.pose,
                     .origin = mesh.mesh().origin(),
                     .from_inside = object.felt_from == Side::inside,
                     .double_sided = options.double_sided,
                     .smooth = options.smooth,
                     .radius = options.radius + ball,
                     .grain = options.grain.amplitude,
                     .grain_wavelength = options.grain.wavelength,
                     .vertices = {},
                     .triangles = {}};
}

SurfaceData surface_data_with_triangles(const Object& object, std::uint16_t index, double ball) {
  SurfaceData data = *surface_data(object, index, ball);
  data.vertices = mesh_of(object)->mesh().vertices();
  data.triangles = mesh_of(object)->mesh().triangles();
  return data;
}

std::shared_ptr<const PrefetchedSurfaces> mesh_surfaces(std::uint32_t version,
                                                        const std::vector<SurfaceData>& surfaces) {
  return std::make_shared<MeshSurfaces>(version, surfaces);
}

}  // namespace feltwire
