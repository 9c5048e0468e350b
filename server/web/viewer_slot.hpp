#pragma once
// Internal to server/web: the hub's data of a scene and of a viewer.

#include "protocol/net/clock.hpp"
#include "server/web/foxglove_viewer.hpp"
#include "server/web/viewer_hub.hpp"
#include "server/web/viewers_hand.hpp"

namespace feltwire::web {

inline constexpr const char* kNoGoodToken =
    "the token is not good: it is unknown, revoked or expired";
inline constexpr double kMessageRate = 20.0, kMessageBurst = 40.0;  // [1/s] of one viewer, at once

/// A scene for viewers.
struct ViewerHub::Stage {
  SceneInView* scene;
  // Made once for all viewers from the shown version.
  std::uint32_t version = 0, changes = 0;
  SharedBytes text, materials;
  std::vector<SharedBytes> geometry;
  Picture picture;
  std::vector<HandRates> rates;  // by rising number
  Picture counted;               // the picture at which the rates begin
  std::vector<HandDescription> hands;
  Nanoseconds described{0};
  bool describing = false;
  std::optional<std::string> hidden;  // the reason why it cannot be seen, as viewers know it
  FoxgloveScene foxglove{clock_offset()};
};

struct ViewerHub::ViewerSlot {
  ViewerSlot(Id number, Viewer* way, const asio::ip::address& from)
      : id(number), viewer(way), address(from) {}
  Id id;
  Viewer* viewer;
  asio::ip::address address;
  std::string token;      // its id; empty: the viewer has shown none yet
  std::string client;     // the name in that token
  bool of_admin = false;  // that token's role
  Stage* stage = nullptr;
  std::string admin = {};                    // id of a second token, of an admin; empty: none
  std::uint32_t version = 0;                 // of the scene that was sent
  std::uint32_t changes = 0;                 // live changes of that scene that it knows
  std::optional<FoxgloveViewer> foxglove{};  // it uses that protocol, not the page's
  TokenBucket messages{kMessageRate, kMessageBurst};  // frames of every kind
  ViewersHand hand;
};

}  // namespace feltwire::web
