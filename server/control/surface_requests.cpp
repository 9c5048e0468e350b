// Answers to the clients of hands that want surfaces in full. The control thread answers the list
// and the parts. TakeSurfaces changes a session, so the scene's thread answers it.

#include <algorithm>

#include "core/mesh/mesh_surface.hpp"
#include "core/whole_surfaces/mesh_surfaces.hpp"
#include "server/control/pending_request.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

/// The scene for a tool that is a point or a ball; null: the tool has a body, or is gone.
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

/// The entries from the `known`-th on, as many as fit.
template <class Entry>
std::vector<Entry> part(const std::vector<Entry>& all, std::uint32_t known) {
  const std::size_t first = std::min<std::size_t>(known, all.size());
  const std::size_t count = std::min(all.size() - first, control::kMaxPart);
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first);
  return {begin, begin + static_cast<std::ptrdiff_t>(count)};
}

control::Message part_of(const SceneInView::CurrentScene& current, const std::string& tool,
                         const control::GetSurface& request) {
  if (request.version != current.version) return other_version(request.version);
  const ToolView* view = view_of(*current.scene, tool);
  if (view == nullptr || !can_travel(*view, request.object))
    return Refused{RefusalCode::bad_parameters, no_surface(request.object)};
  const TriangleMesh& mesh = std::get<Mesh>(view->objects()[request.object].shape).surface->mesh();
  return control::SurfacePart{part(mesh.vertices(), request.vertices),
                              part(mesh.triangles(), request.triangles)};
}

}  // namespace

/// Answers what is about surfaces; false where it is no such request.
bool ControlService::serve_surfaces(PendingRequest& asked, control::Message& request) {
  if (const auto* take = std::get_if<control::TakeSurfaces>(&request)) {
    if (auto refused = refuse_hasty(asked))
      asked.answer(*std::move(refused));
    else
      pass_on(std::move(asked), take->session, std::move(request));
    return true;
  }
  const auto* list = std::get_if<control::ListSurfaces>(&request);
  const auto* get = std::get_if<control::GetSurface>(&request);
  if (list == nullptr && get == nullptr) return false;
  const std::uint64_t session = list != nullptr ? list->session : get->session;
  const ListedSession* seated = own_session(asked, session);
  if (seated == nullptr) {
    asked.answer(unknown_session(session));
    return true;
  }
  const auto current = hosts_[seated->scene]->current_scene();
  asked.answer(get != nullptr ? part_of(current, seated->tool, *get)
                              : control::Message(list_of(current, seated->tool)));
  return true;
}

}  // namespace feltwire
