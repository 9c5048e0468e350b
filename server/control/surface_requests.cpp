#include "server/control/surface_requests.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "core/local_model_extraction/prefetched_tool_data.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"
#include "core/tool/body_tool.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

/// Returns the scene as the tool sees it, if the tool is a point or a ball. Returns null if the
/// tool has a body or does not exist.
const ToolView* view_of(const Scene& scene, const std::string& tool) {
  const ToolView* view = scene.view(tool);
  return view != nullptr && view->tool().body == nullptr ? view : nullptr;
}

control::SurfaceList list_of(const SceneInView::CurrentScene& current, const std::string& tool) {
  control::SurfaceList list{.version = current.version, .surfaces = {}};
  const ToolView* view = view_of(*current.scene, tool);
  if (view == nullptr) return list;
  const auto& objects = view->objects();
  for (std::size_t i = 0; i < view->still() && list.surfaces.size() < control::kMaxSurfaces; ++i) {
    if (i > std::numeric_limits<std::uint16_t>::max()) break;
    auto data = surface_data(objects[i], static_cast<std::uint16_t>(i), view->tool().radius);
    if (!data) continue;
    const TriangleMesh& mesh = std::get<Mesh>(objects[i].shape).surface->mesh();
    list.surfaces.push_back({.surface = *std::move(data),
                             .vertices = static_cast<std::uint32_t>(mesh.vertices().size()),
                             .triangles = static_cast<std::uint32_t>(mesh.triangles().size())});
  }
  return list;
}

/// Returns the entries from index `known` on, at most control::kMaxPart of them.
template <class Entry>
std::vector<Entry> part(const std::vector<Entry>& all, std::uint32_t known) {
  const std::size_t first = std::min<std::size_t>(known, all.size());
  const std::size_t count = std::min(all.size() - first, control::kMaxPart);
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

/// Returns the scene as the tool sees it, if clients may fetch the body of the tool (can_travel).
/// Otherwise returns null, also for an unknown tool.
const ToolView* body_view_of(const Scene& scene, const std::string& tool) {
  const ToolView* view = scene.view(tool);
  return view != nullptr && view->tool().body != nullptr && can_travel(*view->tool().body)
             ? view
             : nullptr;
}

control::SolidEntry solid_entry(const ToolView& view, std::size_t index) {
  control::SolidEntry entry{.solid = solid_data(view, static_cast<std::uint16_t>(index))};
  if (const MeshSurface* mesh = view.sampled_mesh(index)) {
    entry.vertices = static_cast<std::uint32_t>(mesh->mesh().vertices().size());
    entry.triangles = static_cast<std::uint32_t>(mesh->mesh().triangles().size());
  }
  return entry;
}

control::SolidList solids_of(const SceneInView::CurrentScene& current, const std::string& tool) {
  const ToolView* view = body_view_of(*current.scene, tool);
  if (view == nullptr) return {.version = current.version};
  const BodyTool& body = *view->tool().body;
  control::SolidList list{.version = prefetched_version(*view, current.version, current.changes),
                          .body = body_data(body, current.gravity),
                          .points = static_cast<std::uint32_t>(body.shell().points.size())};
  for (std::size_t i = 0; i < view->still() && list.solids.size() < control::kMaxSurfaces; ++i)
    if (can_travel(*view, i)) list.solids.push_back(solid_entry(*view, i));
  return list;
}

control::Message points_of(const SceneInView::CurrentScene& current, const std::string& tool,
                           const control::GetBodyPoints& request) {
  const ToolView* view = body_view_of(*current.scene, tool);
  if (view == nullptr)
    return Refused{RefusalCode::bad_parameters,
                   "this hand's tool has no body to have in full; list the solids first"};
  if (request.version != prefetched_version(*view, current.version, current.changes))
    return other_version(request.version, "solids");
  return control::BodyPoints{part(view->tool().body->shell().points, request.points)};
}

/// Returns the mesh of an object, if a client with the tool of `view` may fetch it; else null.
const MeshSurface* mesh_of(const ToolView* view, std::size_t object) {
  if (view == nullptr || !can_travel(*view, object)) return nullptr;
  return view->tool().body != nullptr ? view->sampled_mesh(object)
                                      : std::get<Mesh>(view->objects()[object].shape).surface.get();
}

control::Message part_of(const SceneInView::CurrentScene& current, const std::string& tool,
                         const control::GetSurface& request) {
  const ToolView* view = current.scene->view(tool);
  if (view != nullptr &&
      request.version != prefetched_version(*view, current.version, current.changes))
    return other_version(request.version, view->tool().body != nullptr ? "solids" : "surfaces");
  const MeshSurface* surface = mesh_of(view, request.object);
  if (surface == nullptr) return Refused{RefusalCode::bad_parameters, no_surface(request.object)};
  control::SurfacePart next{part(surface->mesh().vertices(), request.vertices),
                            part(surface->mesh().triangles(), request.triangles)};
  // Add the origin of the mesh, because the list of solids does not contain it.
  if (view->tool().body != nullptr)
    for (Vec3& vertex : next.vertices) vertex += surface->mesh().origin();
  return next;
}

}  // namespace

std::optional<std::uint64_t> session_of_fetch(const control::Message& request) {
  if (const auto* list = std::get_if<control::ListSurfaces>(&request)) return list->session;
  if (const auto* get = std::get_if<control::GetSurface>(&request)) return get->session;
  if (const auto* list = std::get_if<control::ListSolids>(&request)) return list->session;
  if (const auto* get = std::get_if<control::GetBodyPoints>(&request)) return get->session;
  return std::nullopt;
}

control::Message fetched(const control::Message& request, const SceneInView::CurrentScene& current,
                         const std::string& tool) {
  if (const auto* get = std::get_if<control::GetSurface>(&request))
    return part_of(current, tool, *get);
  if (const auto* get = std::get_if<control::GetBodyPoints>(&request))
    return points_of(current, tool, *get);
  if (std::holds_alternative<control::ListSolids>(request)) return solids_of(current, tool);
  return list_of(current, tool);
}

}  // namespace feltwire
