#pragma once

#include <cstdint>
#include <string>

#include "server/fleet/scene_record.hpp"

namespace feltwire {

enum class WishKind : std::uint8_t {
  drain,    // take no further scene, and hand those that it serves over to other hosts
  undrain,  // take scenes again
  move,     // hand one scene over to one host
};

/// The newest wish of an operator to one host process. A process that starts anew has another
/// number, so an old wish is not carried out again.
struct Wish {
  HostName host;             // that carries it out
  std::uint64_t serial = 0;  // the host takes no wish whose number is not above those before
  WishKind kind = WishKind::drain;
  // A move has these, too:
  std::string scene;
  std::uint64_t term = 0;  // of the epoch at which `host` serves it; at a later one: no more
  HostName target;

  friend bool operator==(const Wish&, const Wish&) = default;
};

}  // namespace feltwire
