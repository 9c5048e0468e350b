// The objects that clients have fetched from a scene: their version, and how a session learns of
// them.

#include "protocol/wire/control.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

/// The data of a body includes materials and gravity. For a point the patches have them.
std::uint32_t prefetched_version(const ToolView& view, std::uint32_t version,
                                 std::uint32_t changes) {
  return view.tool().body != nullptr ? version + changes : version;
}

control::Refused other_version(std::uint32_t version) {
  return {control::RefusalCode::bad_scene, "the scene has no version " + std::to_string(version) +
                                               " any more; list its surfaces again"};
}

control::Message SceneSessions::take_surfaces(const control::TakeSurfaces& request,
                                              Nanoseconds now) {
  SessionSlot** slot = by_id_.find(request.session);
  if (slot == nullptr) return unknown_session(request.session);
  const ToolView* view = scene_->view((*slot)->tool);
  if (view == nullptr || request.version != prefetched_version(*view, version_, live_changes_))
    return other_version(request.version);
  control::TakeSurfaces logged = request;
  logged.session = (*slot)->number;
  const std::vector<std::uint8_t> event = log_.payload(logged);
  if (auto wrong = (*slot)->session.take_surfaces(request.version, request.objects))
    return control::Refused{control::RefusalCode::bad_parameters, *std::move(wrong)};
  log_.put({.kind = EventKind::parameters, .hand = (*slot)->number, .time = now, .payload = event});
  return control::SurfacesTaken{request.session};
}

}  // namespace feltwire
