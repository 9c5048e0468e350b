#pragma once
// A session's slot for tests of one stage of a scene, without the other stages.

#include <memory>

#include "server/scene/session_slot.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"

namespace feltwire::test {

/// The id of a session with this number.
inline constexpr std::uint64_t slot_id(std::uint32_t number) { return std::uint64_t{number} << 8; }

/// A session that joined at time 0. The scene, and the world if there is one, must outlive it.
inline std::unique_ptr<SessionSlot> make_slot(const Scene& scene, std::uint32_t number,
                                              const control::JoinRequest& request = join_request(),
                                              World* world = nullptr,
                                              const SessionLimits& limits = {}) {
  const std::uint64_t id = slot_id(number);
  auto slot = std::make_unique<SessionSlot>(id, request, *scene.view(request.tool), world, keys(id),
                                            limits, Nanoseconds{0});
  slot->number = number;
  return slot;
}

}  // namespace feltwire::test
