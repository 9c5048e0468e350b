#pragma once
// Internal to server/web: an audience's data of a scene and of a viewer.

#include "protocol/net/clock.hpp"
#include "server/web/audience.hpp"
#include "server/web/foxglove_viewer.hpp"
#include "server/web/viewers_hand.hpp"

namespace feltwire::web {

inline constexpr const char* kNoGoodToken =
    "the token is not good: it is unknown, revoked or expired";
inline constexpr double kMessageRate = 20.0, kMessageBurst = 40.0;  // [1/s] of one viewer, at once

/// One scene for viewers.
struct Audience::Stage {
  SceneInView* scene;
  // Of the shown version, made once for all viewers.
  std::uint32_t version = 0, changes = 0;
  std::string text, materials;
  std::vector<Bytes> geometry;
  Picture picture;
  std::vector<HandRates> rates;  // by rising number
  Picture counted;               // the picture at which the rates begin
  std::vector<HandDescription> hands;
  Nanoseconds described{0};
  bool describing = false;
  std::optional<std::string> hidden;  // the reason why it cannot be seen, as viewers know it
  FoxgloveScene foxglove{clock_offset()};
};

struct Audience::ViewerSlot {
  ViewerSlot(Id number, Viewer* way, const Network& from)
      : id(number), viewer(way), network(from) {}
  Id id;
  Viewer* viewer;
  Network network;
  std::string token;  // its id; empty: the viewer has shown none yet
  Stage* stage = nullptr;
  std::string admin = {};                    // id of a second token, of an admin; empty: none
  std::uint32_t version = 0;                 // of the scene that was sent
  std::uint32_t changes = 0;                 // live changes of that scene that it knows
  std::optional<FoxgloveViewer> foxglove{};  // it uses that protocol, not the page's
  TokenBucket messages{kMessageRate, kMessageBurst};
  ViewersHand hand;
};

}  // namespace feltwire::web
