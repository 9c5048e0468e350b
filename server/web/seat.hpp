#pragma once
// Internal to server/web: what an audience knows of a scene and of a viewer.

#include <chrono>

#include "protocol/net/clock.hpp"
#include "server/web/audience.hpp"
#include "server/web/foxglove_viewer.hpp"
#include "server/web/viewers_hand.hpp"

namespace feltwire::web {

inline constexpr double kMessageRate = 20.0, kMessageBurst = 40.0;  // [1/s] of one viewer, at once

inline CalendarTime calendar_now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

/// [ns] from the scenes' clock to the time since 1970.
inline std::int64_t since_1970() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return (std::chrono::duration_cast<Nanoseconds>(now) - monotonic_now()).count();
}

/// One scene as it is shown.
struct Audience::Stage {
  SceneHost* host;
  // Of the version that is shown, made once for all viewers.
  std::uint32_t version = 0, changes = 0;
  std::string text, materials;
  std::vector<Bytes> geometry;
  Picture picture;
  std::vector<HandRates> rates;  // by rising number
  Picture counted;               // the picture that the rates begin at
  std::vector<HandDescription> hands;
  Nanoseconds described{0};
  bool describing = false;
  FoxgloveScene foxglove{since_1970()};
};

struct Audience::Seat {
  Seat(Id number, Viewer* way, const Network& from) : id(number), viewer(way), network(from) {}
  Id id;
  Viewer* viewer;
  Network network;
  std::string token;  // its id; empty: none was shown yet
  Stage* stage = nullptr;
  std::string admin = {};                    // likewise, of a second one, of an admin; empty: none
  std::uint32_t version = 0;                 // of the scene that was sent
  std::uint32_t changes = 0;                 // live ones of that scene, of which it was told
  std::optional<FoxgloveViewer> foxglove{};  // it speaks that protocol, not the page's
  TokenBucket messages{kMessageRate, kMessageBurst};
  ViewersHand hand;
};

}  // namespace feltwire::web
