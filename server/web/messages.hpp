#pragma once
// What the live page is told: texts (JSON) and binary messages, as docs/live_page.md lists them. No
// socket.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.hpp"
#include "protocol/session/role.hpp"
#include "server/picture/picture.hpp"
#include "server/web/page_hands.hpp"

namespace feltwire::web {

using Bytes = std::vector<std::uint8_t>;

/// The first answer to a viewer whose token is good.
std::string hello(std::span<const std::string> scenes, Role role);

/// Where another program may look on with a ticket, and for how long it may be used.
std::string ticket_text(std::string_view scene, std::string_view ticket, std::chrono::seconds life);

/// A scene without its triangles.
std::string scene_text(const Scene& scene, std::uint32_t version);
/// The materials of its objects as they are now, and gravity on what moves.
std::string materials_text(const Scene& scene, std::uint32_t version,
                           const std::optional<Vec3>& gravity);
/// To an admin who asked for something: it was done, or why it was not.
std::string changed_text(std::string_view what);
std::string refused(std::string_view reason);
/// A second token has made the viewer an admin.
std::string admin_text();
/// A line for people. Level: info, warning, error.
std::string log_text(std::string_view level, std::string_view line);
/// The triangles of each object but planes, which the text tells. Allocates, and may take some 10
/// ms.
std::vector<Bytes> geometry(const Scene& scene, std::uint32_t version);

/// How a hand's line does, over the time since the last description.
struct HandRates {
  std::uint32_t number = 0;
  double samples = 0.0;  // [1/s] taken
  double loss = 0.0;     // share of the samples that were sent, 0 to 1
};
/// Both in rising order of the hands' numbers; a hand without rates has zeros. `begin`: time 0 of
/// the page's clock.
Bytes picture(const Picture& picture, std::span<const HandRates> rates, Nanoseconds begin);

/// The surfaces near the hands, of those that have a local model. Empty where none has.
Bytes surfaces(const Picture& picture);

/// `time` [s] of the page's clock.
std::string sessions(std::span<const HandDescription> hands, const Picture& picture,
                     std::span<const HandRates> rates, double time);

/// The state of a viewer's own hand.
std::string hand_text(const PageHand::Status& status);
/// For a viewer without a hand: `free` (it may take one) or `refused`, with the reason.
std::string hand_text(std::string_view state, std::string_view reason = {});

}  // namespace feltwire::web
