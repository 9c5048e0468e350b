#include "core/scene_file/read_polygons.hpp"

#include <stdexcept>
#include <utility>

#include "core/dynamics/mass_properties.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene_file/read_parts.hpp"
#include "core/scene_file/read_values.hpp"

namespace feltwire {
namespace {

using Corners = std::vector<std::vector<Vec3>>;

std::string use_of_tool(const scene_file::ToolBody& body) {
  const auto* given = body.convex_parts();
  const DecompositionOptions usual;
  const bool own = given != nullptr && !std::isnan(given->tolerance());
  return number_text(body.scale()) + "." + (own ? number_text(given->tolerance()) : "auto") + "." +
         std::to_string(given != nullptr ? given->most() : usual.most);
}

Corners parts_of_tool(const JsonDocument& document, const std::string& path,
                      const scene_file::ToolBody& body, const TriangleSoup& surface,
                      const std::filesystem::path& folder) {
  const MeshSurface mesh{TriangleMesh(surface, {}, true)};
  if (!mesh.mesh().report().closed() || !(mesh.mesh().report().volume > 0.0))
    document.fail(path + ".contact",
                  "is polygons, but the surface is not closed with its normals outwards; mend the "
                  "mesh, or take points");
  if (is_convex(mesh.mesh())) return {surface.vertices};
  if (body.file() == nullptr)
    document.fail(path + ".contact",
                  "is polygons, but this solid is not convex; give a mesh, or take points");
  const DecompositionOptions options =
      read_parts_options(document, path + ".convex_parts", body.convex_parts(), mesh);
  return read_tool_parts(document, folder, {path + ".file", body.file()->str(), use_of_tool(body)},
                         mesh, options);
}

SolidParts parts_of_object(const JsonDocument& document, const Object& object,
                           const std::filesystem::path& folder, const scene_file::Scene& file) {
  const MeshSurface* surface = hollow_mesh(object);
  if (surface == nullptr) return solid_parts(object.shape, object.felt_from);
  flatbuffers::uoffset_t i = 0;
  const flatbuffers::uoffset_t count = file.objects() != nullptr ? file.objects()->size() : 0;
  while (i < count && file.objects()->Get(i)->name()->str() != object.name) ++i;
  if (i == count)  // The scene file does not list the object, so it comes from an MJCF file.
    return solid_parts(object.shape, object.felt_from);
  const std::string path = element("objects", i) + ".mesh";
  const scene_file::Mesh& mesh = *file.objects()->Get(i)->mesh();
  return solid_parts(read_tool_parts(document, folder, {path, mesh.file()->str(), use_of(mesh)},
                                     *surface, read_parts_options(document, path, mesh, *surface)));
}

}  // namespace

std::shared_ptr<const PolygonBody> read_polygons(
    const JsonDocument& document, const std::string& path, const scene_file::ToolBody& body,
    const TriangleSoup& surface, const Pose& place, const std::filesystem::path& folder,
    const scene_file::Scene& file, const Scene& scene) {
  const std::string contact = body.contact() != nullptr ? body.contact()->str() : "points";
  if (contact == "points") {
    if (body.convex_parts() != nullptr)
      document.fail(path + ".convex_parts",
                    "is for a tool of polygons; give contact \"polygons\", or leave it out");
    return nullptr;
  }
  if (contact != "polygons")
    document.fail(path + ".contact", "must be one of: points, polygons; is '" + contact + "'");
  Corners parts = parts_of_tool(document, path, body, surface, folder);
  for (auto& part : parts)
    for (Vec3& corner : part) corner = place.position + place.orientation * corner;
  std::vector<SolidParts> solids;
  for (const Object& object : scene.objects()) {
    try {
      solids.push_back(parts_of_object(document, object, folder, file));
    } catch (const std::invalid_argument& error) {
      document.fail(path + ".contact", "is polygons, but object '" + object.name +
                                           "' cannot be touched by it: " + error.what());
    }
  }
  try {
    return std::make_shared<const PolygonBody>(polygon_body(parts, std::move(solids)));
  } catch (const std::invalid_argument& error) {
    document.fail(path + ".contact", error.what());
  }
}

}  // namespace feltwire
