#include "client/transport/listing.hpp"

#include <utility>

namespace feltwire {
namespace {

std::size_t bytes_of(const control::SessionDescription& session) {
  std::size_t bytes = sizeof session;
  for (const std::string* text :
       {&session.client, &session.device, &session.tool, &session.changes.asked, &session.seat})
    bytes += text->capacity();
  return bytes;
}

std::string of_scene(const std::string& scene) { return " of scene '" + scene + "'"; }

}  // namespace

std::deque<control::SessionDescription> described_sessions(ControlDialogue& dialogue,
                                                           const std::string& scene,
                                                           ListRoom& room) {
  std::deque<control::SessionDescription> sessions;  // a deque needs no second buffer to grow
  std::uint32_t after = 0;
  for (bool more = true; more;) {
    auto list =
        dialogue.ask_for<control::SessionDescriptions>(control::DescribeSessions{scene, after});
    more = list.more;
    if (more && list.sessions.empty())
      dialogue.refuse("said that there are more sessions" + of_scene(scene) + ", and listed none");
    for (control::SessionDescription& session : list.sessions) {
      if (session.number <= after)
        dialogue.refuse("listed the sessions" + of_scene(scene) + " not by rising number");
      if (!room.take(bytes_of(session)))
        dialogue.refuse("listed sessions of more than " + std::to_string(room.bytes()) +
                        " bytes, those" + of_scene(scene) + " among them");
      after = session.number;
      sessions.push_back(std::move(session));
    }
  }
  return sessions;
}

DescribedMaterials described_materials(ControlDialogue& dialogue, const std::string& scene,
                                       std::size_t objects) {
  DescribedMaterials all;
  do {
    const auto from = static_cast<std::uint32_t>(all.materials.size());
    all.scene = dialogue.ask_for<control::SceneDescription>(control::DescribeScene{scene, from});
    const std::vector<Material> part = std::exchange(all.scene.materials, {});
    if (all.scene.objects != objects) return {std::move(all.scene), {}};
    if (part.size() > objects - all.materials.size() || (part.empty() && objects > 0))
      dialogue.refuse("described " + std::to_string(part.size()) + " materials" + of_scene(scene) +
                      ", where " + std::to_string(objects - all.materials.size()) + " are missing");
    all.materials.insert(all.materials.end(), part.begin(), part.end());
  } while (all.materials.size() < objects);
  return all;
}

}  // namespace feltwire
