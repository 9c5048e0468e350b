#pragma once
// The messages to the live page: texts (JSON) and binary messages, as docs/live_page.md lists them.
// It has no socket.

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.hpp"
#include "protocol/session/role.hpp"
#include "protocol/wire/control.hpp"
#include "server/picture/picture.hpp"
#include "server/web/page_hands.hpp"

namespace feltwire::web {

using Bytes = std::vector<std::uint8_t>;

/// The first answer to a viewer with a valid token. `observes`: no viewer of this page can change
/// anything.
std::string hello(std::span<const std::string> scenes, Role role, bool observes);

/// The address at which another program may observe with a ticket, and the life of the ticket.
std::string ticket_text(std::string_view scene, std::string_view ticket, std::chrono::seconds life);

/// A scene without its triangles.
std::string scene_text(const Scene& scene, std::uint32_t version);
/// The present materials of its objects, and gravity on moving objects.
std::string materials_text(const Scene& scene, std::uint32_t version,
                           const std::optional<Vec3>& gravity);
/// The answer to an admin's request: it was done, or the reason why not.
std::string changed_text(std::string_view what);
std::string refused(std::string_view reason);
/// The recordings of a scene at the server, for its admins.
std::string recordings_text(const control::SceneRecordings& recordings);
/// The address of a recording, which may be fetched once with this ticket.
std::string download_text(std::string_view name, std::string_view ticket);
/// A second token has made the viewer an admin.
std::string admin_text();
/// A line for people. Level: info, warning, error.
std::string log_text(std::string_view level, std::string_view line);
/// The triangles of each object except planes, which the text contains. Allocates, and may take
/// some 10 ms.
std::vector<Bytes> geometry(const Scene& scene, std::uint32_t version);

/// The quality of a hand's line, over the time since the last description.
struct HandRates {
  std::uint32_t number = 0;
  double samples = 0.0;  // [1/s] taken
  double loss = 0.0;     // share of the samples that were sent, 0 to 1
};
/// Both in rising order of the hands' numbers; a hand without rates has zeros. `begin`: time 0 of
/// the page's clock.
Bytes picture(const Picture& picture, std::span<const HandRates> rates, Nanoseconds begin);

/// The surfaces near the hands with a local model. Empty if there are none.
Bytes surfaces(const Picture& picture);

/// `time` [s] of the page's clock.
std::string sessions(std::span<const HandDescription> hands, const Picture& picture,
                     std::span<const HandRates> rates, double time);

/// The state of a viewer's own hand.
std::string hand_text(const PageHand::Status& status);
/// For a viewer without a hand: `free` (it may take one) or `refused`, with the reason.
std::string hand_text(std::string_view state, std::string_view reason = {});

}  // namespace feltwire::web
