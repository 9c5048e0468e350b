#pragma once
// The page's data of one viewer.

#include <asio/ip/address.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/base/token_bucket.hpp"
#include "server/web/foxglove_viewer.hpp"
#include "server/web/ping_schedule.hpp"
#include "server/web/viewer.hpp"
#include "server/web/viewers_hand.hpp"

namespace feltwire::web {

class ViewedScene;

inline constexpr double kMessageRate = 20.0, kMessageBurst = 40.0;  // [1/s] of one viewer, at once

using ViewerId = std::uint64_t;

struct ViewerSlot {
  ViewerSlot(ViewerId number, Viewer* way, const asio::ip::address& from)
      : id(number), viewer(way), address(from) {}
  ViewerId id;
  Viewer* viewer;
  asio::ip::address address;
  std::string token;                         // its id; empty: the viewer has shown none yet
  std::string client;                        // the name in that token
  bool of_admin = false;                     // that token's role
  ViewedScene* scene = nullptr;              // it watches this one; null: none yet
  std::string admin = {};                    // id of a second token, of an admin; empty: none
  std::uint32_t version = 0;                 // of the scene that was sent
  std::uint32_t changes = 0;                 // live changes of that scene that it knows
  std::string recordings = {};               // the text about them that it got last
  std::optional<FoxgloveViewer> foxglove{};  // it uses that protocol, not the page's
  std::optional<PingSchedule> pings{};       // of such a viewer, which may get no other message
  TokenBucket messages{kMessageRate, kMessageBurst};  // frames of every kind
  ViewersHand hand;
};
using ViewerSlots = std::map<ViewerId, ViewerSlot>;

}  // namespace feltwire::web
