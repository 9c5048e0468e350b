#pragma once
// Messages of the Foxglove WebSocket protocol, as far as an observing server needs them
// (docs/live_page.md). It has no socket.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/page_messages.hpp"

namespace feltwire::web {

/// The channels that a viewer may subscribe to. The number of a channel on the wire is its index
/// here.
enum class FoxgloveChannel : std::uint8_t {
  geometry,    // the shapes of the scene's objects, at a change
  transforms,  // the places of moving objects
  picture,     // the hands, and the force on each
  hands,       // their figures
  count_of_channels
};
inline constexpr std::size_t kFoxgloveChannels =
    static_cast<std::size_t>(FoxgloveChannel::count_of_channels);

/// The first message to a viewer: the properties of this server.
std::string foxglove_server_info(std::string_view scene);
/// The second: all channels, with their schemas.
std::string foxglove_advertisement();

enum class FoxgloveLevel : std::uint8_t { info = 0, warning = 1, error = 2 };
/// For the viewer's list of problems.
std::string foxglove_status(FoxgloveLevel level, std::string_view message);

/// The begin of a message of a channel, for one subscription; its payload follows. `time` [ns]
/// since 1970.
Bytes foxglove_data_head(std::uint32_t subscription, std::uint64_t time);

/// A request of a viewer. Members that its operation does not need are not read.
struct FoxgloveRequest {
  struct Subscription {
    std::uint32_t id = 0, channel = 0;
  };
  std::string operation;                      // "subscribe"
  std::vector<Subscription> subscriptions{};  // of subscribe
  std::vector<std::uint32_t> ended{};         // of unsubscribe: subscriptions' ids
};

/// Empty if the text is no JSON object with an operation, is nested too deep, or has an id that is
/// no 32 bit number.
std::optional<FoxgloveRequest> parse_foxglove_request(std::string_view text);

}  // namespace feltwire::web
