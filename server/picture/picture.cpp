#include "server/picture/picture.hpp"

#include <array>

namespace feltwire {
namespace {

struct StateText {
  const char* name;
  bool takes_off;
  const char* text;
};
constexpr std::array<StateText, kHandStates> kStates = {{
    {"waiting", false, "No sample of this hand has come yet."},
    {"silent", true,
     "Nothing has come from this hand for longer than its hold time, so its force has faded."},
    {"free_space", false, "The tool touches nothing."},
    {"touching", false, "The scene asks for a force."},
    {"gap", false, "Samples were lost on the way."},
    {"server_bound", true, "The server's energy bound takes something off the force."},
    {"saturated", true, "The scene asks for more than the device's largest force."},
    {"refused", true, "The movement was out of range, so no force was computed."},
    {"recovering", true, "Moving objects were put back to a good state and are felt in part."},
    {"client_less", true,
     "The device holds less than the scene asks for: the client's energy bound, its account or one "
     "of its limits takes something off."},
    {"moves_robot", false, "It moves a robot, and feels what the robot touches."},
}};

}  // namespace

const char* name(HandState state) noexcept { return kStates[static_cast<std::size_t>(state)].name; }
const char* text(HandState state) noexcept { return kStates[static_cast<std::size_t>(state)].text; }
bool takes_off(HandState state) noexcept {
  return kStates[static_cast<std::size_t>(state)].takes_off;
}

}  // namespace feltwire
