#include "core/scene_file/read_parts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <stdexcept>
#include <tuple>

#include "core/base/cancellation.hpp"
#include "core/dynamics/mass_properties.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/polyhedra/polyhedron.hpp"
#include "core/scene_file/parts_cache.hpp"
#include "core/scene_file/read_values.hpp"

namespace feltwire {
namespace {

std::string millimetres(double length) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g mm", 1e3 * length);
  return text.data();
}

std::string counted(std::size_t parts) {
  return std::to_string(parts) + (parts == 1 ? " convex part" : " convex parts");
}

/// Computes the convex parts of each mesh only once.
class Parts {
 public:
  Parts(const JsonDocument& document, std::filesystem::path folder)
      : document_(document), folder_(std::move(folder)) {}

  std::shared_ptr<const ConvexSolids> of(const std::string& path, const std::string& object,
                                         const scene_file::Mesh& mesh, const MeshSurface& surface) {
    const DecompositionOptions options = read_parts_options(document_, path, mesh, surface);
    const auto [at, is_new] = known_.try_emplace(
        std::tuple(&surface, tolerance_of(options, surface.mesh()), options.most));
    if (is_new) at->second = found(path, object, mesh, surface, options);
    return at->second;
  }

  std::vector<std::string> notes, warnings;

 private:
  std::shared_ptr<const ConvexSolids> found(const std::string& path, const std::string& object,
                                            const scene_file::Mesh& mesh,
                                            const MeshSurface& surface,
                                            const DecompositionOptions& options) {
    if (options.most == 1) return hull(surface);
    begin_stage(path + ".convex_parts");
    const std::string name = mesh.file()->str();
    try {
      const FoundParts parts = find_parts({folder_, name, use_of(mesh)}, surface, options);
      tell(name, object, parts);
      if (parts.parts.parts.empty()) throw std::runtime_error("none was found");
      return std::make_shared<ConvexSolids>(parts.parts.parts);
    } catch (const std::runtime_error& error) {
      warnings.push_back("object '" + object + "': " + name + " has no convex parts (" +
                         error.what() +
                         "), so bodies run into its convex hull; mend the mesh, or build it from "
                         "several convex objects");
      return hull(surface);
    }
  }

  static std::shared_ptr<const ConvexSolids> hull(const MeshSurface& surface) {
    return std::make_shared<ConvexSolids>(1, surface.mesh().vertices());
  }

  void tell(const std::string& name, const std::string& object, const FoundParts& found) {
    const ConvexParts& parts = found.parts;
    std::array<char, 64> time{};
    std::snprintf(time.data(), time.size(), ", computed in %.2f s", found.seconds);
    notes.push_back("object '" + object + "': bodies run into " + counted(parts.parts.size()) +
                    " of " + name + ", at most " + millimetres(parts.outside) +
                    " out of it (tolerance " + millimetres(parts.tolerance) + ")" +
                    (found.computed ? time.data() : "") +
                    (found.place.empty() ? ""
                     : found.computed    ? ", kept in " + found.place
                                         : ", read from " + found.place));
    for (const std::string& remark : found.remarks)
      notes.push_back("object '" + object + "': convex parts: " + remark);
    if (parts.outside > parts.tolerance)
      warnings.push_back("object '" + object + "': the " + counted(parts.parts.size()) +
                         " that bodies run into reach up to " + millimetres(parts.outside) +
                         " out of the mesh, more than convex_parts.tolerance, " +
                         millimetres(parts.tolerance) +
                         "; give a larger tolerance, or more parts with convex_parts.most");
  }

  const JsonDocument& document_;
  std::filesystem::path folder_;
  std::map<std::tuple<const MeshSurface*, double, std::size_t>, std::shared_ptr<const ConvexSolids>>
      known_;
};

}  // namespace

std::string use_of(const scene_file::Mesh& mesh) {
  const auto* given = mesh.convex_parts();
  const bool own = given != nullptr && !std::isnan(given->tolerance());
  return (mesh.unit() != nullptr ? mesh.unit()->str() : number_text(mesh.scale())) + "." +
         (own ? number_text(given->tolerance()) : "auto") + "." +
         std::to_string(given != nullptr ? given->most() : DecompositionOptions{}.most);
}

const MeshSurface* hollow_mesh(const Object& object) {
  const auto* mesh = std::get_if<Mesh>(&object.shape);
  if (mesh == nullptr || object.felt_from == Side::inside) return nullptr;
  const TriangleMesh& triangles = mesh->surface->mesh();
  const MeshReport& report = triangles.report();
  const bool solid = report.closed() && report.volume > 0.0;
  return solid && !is_convex(triangles) ? mesh->surface.get() : nullptr;
}

DecompositionOptions read_parts_options(const JsonDocument& document, const std::string& path,
                                        const scene_file::Mesh& mesh, const MeshSurface& surface) {
  return read_parts_options(document, path + ".convex_parts", mesh.convex_parts(), surface);
}

std::vector<std::vector<Vec3>> read_tool_parts(const JsonDocument& document,
                                               const std::filesystem::path& folder,
                                               const ToolMesh& mesh, const MeshSurface& surface,
                                               const DecompositionOptions& options) {
  // largest error of a part with fewer corners, as a share of the parts' tolerance
  constexpr double kLeftOut = 0.25;
  begin_stage(mesh.path + ".convex_parts");
  std::vector<std::vector<Vec3>> parts;
  try {
    for (const auto& part :
         find_parts({folder, mesh.name, mesh.use}, surface, options).parts.parts) {
      auto corners = fewer_corners(part, kLeftOut * tolerance_of(options, surface.mesh()));
      for (Vec3& corner : corners) corner += surface.mesh().origin();
      parts.push_back(std::move(corners));
    }
  } catch (const std::runtime_error& error) {
    document.fail(mesh.path, mesh.name + " has no convex parts (" + error.what() +
                                 "); mend the mesh, or take a tool of points");
  }
  if (parts.empty())
    document.fail(mesh.path,
                  mesh.name + " has no convex parts; mend the mesh, or take a tool of points");
  return parts;
}

DecompositionOptions read_parts_options(const JsonDocument& document, const std::string& own,
                                        const scene_file::ConvexParts* given,
                                        const MeshSurface& surface) {
  DecompositionOptions options;
  if (given == nullptr) return options;
  options.most = given->most();
  if (options.most < 1 || options.most > kMostParts)
    document.fail(own + ".most", "must be 1 to " + std::to_string(kMostParts) + ", is " +
                                     std::to_string(options.most) +
                                     "; give 1 for the convex hull of the whole");
  if (std::isnan(given->tolerance())) return options;
  require(document, own, positive("tolerance", given->tolerance(), kMaxLength, " [m]"));
  const double least = kLeastPartTolerance * surface.mesh().report().size;
  if (given->tolerance() < least)
    document.fail(own + ".tolerance", "must be at least " + number_text(kLeastPartTolerance) +
                                          " of the mesh's longest side, " + number_text(least) +
                                          " m, is " + number_text(given->tolerance()) +
                                          "; give a larger one");
  options.tolerance = given->tolerance();
  return options;
}

CollisionParts read_collision_parts(const JsonDocument& document, const scene_file::Scene& scene,
                                    const std::filesystem::path& folder,
                                    const std::vector<Object>& objects,
                                    const std::vector<int>& body_of,
                                    const std::vector<Body>& bodies) {
  CollisionParts result;
  if (std::ranges::none_of(bodies, &Body::collides)) return result;
  result.of_object.resize(objects.size());
  Parts parts(document, folder);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    if (body_of[i] >= 0 && !bodies[static_cast<std::size_t>(body_of[i])].collides) continue;
    const MeshSurface* surface = hollow_mesh(objects[i]);
    if (surface == nullptr) continue;
    check_cancelled();
    const auto& mesh = *scene.objects()->Get(static_cast<flatbuffers::uoffset_t>(i))->mesh();
    result.of_object[i] =
        parts.of(element("objects", i) + ".mesh", objects[i].name, mesh, *surface);
  }
  result.notes = std::move(parts.notes);
  result.warnings = std::move(parts.warnings);
  return result;
}

}  // namespace feltwire
