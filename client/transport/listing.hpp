#pragma once
// Lists that a server tells in several answers: its sessions, and the materials of a scene.
//
// A server can tell without end. So the memory for it is limited, and the listing ends with a
// reason if an answer brings nothing new.

#include <cstddef>
#include <deque>
#include <string>
#include <vector>

#include "client/transport/control_dialogue.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {

/// The memory that may be taken for lists of one or of many scenes.
class ListRoom {
 public:
  explicit ListRoom(std::size_t bytes) : bytes_(bytes), left_(bytes) {}
  /// Whether so many more fit; then they take their place.
  bool take(std::size_t bytes) noexcept {
    if (bytes > left_) return false;
    left_ -= bytes;
    return true;
  }
  std::size_t bytes() const { return bytes_; }  // at the beginning

 private:
  std::size_t bytes_, left_;
};

/// [bytes] The sessions of all scenes of a server: more than 2000 with usual names. A program that
/// lists them has some 14 MB without them.
inline constexpr std::size_t kRoomOfServer = std::size_t{2} << 20;
/// [bytes] The counters of all scenes of a server. The largest server has half of it.
inline constexpr std::size_t kRoomOfCounters = std::size_t{1} << 20;
/// [bytes] The least for a scene, where several share the room of a server.
inline constexpr std::size_t kLeastRoomOfScene = std::size_t{128} << 10;

/// All sessions of a scene, by rising number. Throws SessionError, and FalseAnswer if they have no
/// room, do not rise, or if the server says that there are more and lists none.
std::deque<control::SessionDescription> described_sessions(ControlDialogue& dialogue,
                                                           const std::string& scene,
                                                           ListRoom& room);

/// The materials of a scene, and what the server said of it with the last of them.
struct DescribedMaterials {
  control::SceneDescription scene;  // without materials
  std::vector<Material> materials;  // one for each object, from the first on
};
/// Asks for the materials of a scene that has so many objects. If the server's has another number
/// of them, there are no materials. Throws SessionError, and FalseAnswer if an answer brings
/// materials of more objects than there are, or none.
DescribedMaterials described_materials(ControlDialogue& dialogue, const std::string& scene,
                                       std::size_t objects);

}  // namespace feltwire
