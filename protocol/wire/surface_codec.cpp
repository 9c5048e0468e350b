#include "protocol/wire/surface_codec.hpp"

#include <vector>

#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/control_values.hpp"

namespace feltwire::control {

flatbuffers::Offset<wire::SurfaceList> build(flatbuffers::FlatBufferBuilder& builder,
                                             const SurfaceList& list) {
  std::vector<flatbuffers::Offset<wire::SurfaceEntry>> entries;
  for (const SurfaceEntry& entry : list.surfaces) {
    const SurfaceData& s = entry.surface;
    const wire::Vector position = wire_vector(s.pose.position), origin = wire_vector(s.origin);
    const wire::Turn orientation = wire_turn(s.pose.orientation);
    entries.push_back(wire::CreateSurfaceEntry(
        builder, s.object, &position, &orientation, &origin, s.from_inside, s.double_sided,
        s.smooth, s.radius, s.grain, s.grain_wavelength, entry.vertices, entry.triangles));
  }
  return wire::CreateSurfaceList(builder, list.version, builder.CreateVector(entries));
}

flatbuffers::Offset<wire::SurfacePart> build(flatbuffers::FlatBufferBuilder& builder,
                                             const SurfacePart& part) {
  std::vector<wire::Vector> vertices;
  for (const Vec3& v : part.vertices) vertices.push_back(wire_vector(v));
  std::vector<wire::Corners> triangles;
  for (const Triangle& t : part.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  const auto wire_vertices = builder.CreateVectorOfStructs(vertices);
  return wire::CreateSurfacePart(builder, wire_vertices, builder.CreateVectorOfStructs(triangles));
}

bool read(const wire::SurfaceList& from, SurfaceList& to) {
  to.version = from.version();
  if (from.surfaces()->size() > kMaxSurfaces) return false;
  for (const wire::SurfaceEntry* entry : *from.surfaces())
    to.surfaces.push_back(
        {.surface = {.object = entry->object(),
                     .pose = {vector(*entry->position()), turn(*entry->orientation())},
                     .origin = vector(*entry->origin()),
                     .from_inside = entry->from_inside(),
                     .double_sided = entry->double_sided(),
                     .smooth = entry->smooth(),
                     .radius = entry->radius(),
                     .grain = entry->grain(),
                     .grain_wavelength = entry->grain_wavelength(),
                     .vertices = {},
                     .triangles = {}},
         .vertices = entry->vertices(),
         .triangles = entry->triangles()});
  return true;
}

bool read(const wire::SurfacePart& from, SurfacePart& to) {
  if (from.vertices()->size() > kMaxPart || from.triangles()->size() > kMaxPart) return false;
  if (!aligned(*from.vertices(), alignof(double))) return false;
  for (const wire::Vector* v : *from.vertices()) to.vertices.push_back(vector(*v));
  for (const wire::Corners* t : *from.triangles()) to.triangles.push_back({t->a(), t->b(), t->c()});
  return true;
}

bool read(const wire::TakeSurfaces& from, TakeSurfaces& to) {
  if (from.objects()->size() > kMaxSurfaces) return false;
  to.session = from.session();
  to.version = from.version();
  to.objects.assign(from.objects()->begin(), from.objects()->end());
  return true;
}

}  // namespace feltwire::control
