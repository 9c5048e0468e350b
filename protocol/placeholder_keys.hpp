#pragma once
// TO BE DELETED when the control connection brings the keys: both ends make them from the session's
// number, which guards nothing.

#include "core/splitmix.hpp"
#include "protocol/aead.hpp"

namespace feltwire {

inline SessionKeys placeholder_keys(std::uint64_t session) {
  SessionKeys keys;
  keys.suite = preferred_suite();
  for (std::size_t i = 0; i < kKeySize; ++i) {
    keys.up[i] = static_cast<std::uint8_t>(splitmix::draw(session, i));
    keys.down[i] = static_cast<std::uint8_t>(splitmix::draw(session, kKeySize + i));
  }
  return keys;
}

}  // namespace feltwire
