#include "gateway/remote_scene/near_surfaces.hpp"

#include <algorithm>

#include "core/contact/contact.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "gateway/remote_scene/seen_picture.hpp"

namespace feltwire {

void NearSurfaces::begin(const std::shared_ptr<const Scene>& scene) {
  scene_ = scene;
  hands_.clear();
  surroundings_.clear();
  for (const ToolView& view : scene->views()) surroundings_.push_back({&view, view.objects()});
}

NearSurfaces::Hand& NearSurfaces::hand(std::uint32_t number, std::size_t tool) {
  auto at = std::ranges::lower_bound(hands_, number, {}, &Hand::number);
  if (at == hands_.end() || at->number != number)
    at = hands_.insert(at, {number, tool, surroundings_[tool].view->memory()});
  if (at->tool != tool) *at = {number, tool, surroundings_[tool].view->memory()};
  return *at;
}

void NearSurfaces::add(const std::shared_ptr<const Scene>& scene, const ObservedScene& seen,
                       std::span<const control::SessionDescription> told, Picture& picture) {
  if (scene_ != scene) begin(scene);
  std::erase_if(hands_, [&](const Hand& hand) { return !seen.hands().contains(hand.number); });
  for (Surroundings& around : surroundings_)
    for (const PictureBody& body : picture.bodies) around.objects[body.object].pose = body.pose;
  std::size_t count = 0;
  for (PictureHand& drawn : picture.hands) {
    if (++count > kMostPictureSurfaces) return;
    const auto& figures = seen.hands().at(drawn.number).figures;
    const control::SessionDescription* session = told_of(told, drawn.number);
    if (!figures || figures->samples == 0 || figures->tool >= surroundings_.size() ||
        session == nullptr || !session->parameters.local_model)
      continue;
    const auto& [view, objects] = surroundings_[figures->tool];
    if (view->tool().body) continue;
    TouchMemory& memory = hand(drawn.number, figures->tool).memory;
    const Vec3& position = drawn.pose.position;
    view->touch_still({position}, memory);
    for (std::size_t i = view->still(); i < objects.size(); ++i)
      memory[i].touching =
          surface_point(objects[i], position, view->tool().radius, memory[i].feature).depth > 0.0;
    drawn.surfaces = local_model(*view, objects, position, memory);
  }
}

}  // namespace feltwire
