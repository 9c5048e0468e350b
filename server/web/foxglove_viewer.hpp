#pragma once
// A viewer of the Foxglove protocol: its subscriptions, and the messages that it has got.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/web/foxglove_scene.hpp"
#include "server/web/viewer.hpp"

namespace feltwire::web {

class FoxgloveViewer {
 public:
  /// Sends the properties of this server and its channels at once. `viewer` outlives this.
  FoxgloveViewer(Viewer& viewer, std::string_view scene);

  /// Takes a text message of the viewer. An impossible request is answered with a status; the
  /// connection stays.
  void receive(std::string_view message);
  /// Sends the newest message of each channel that is subscribed to, unless it was sent before.
  void show(const FoxgloveScene& scene);

 private:
  struct Subscription {
    std::uint32_t id = 0;
    std::uint64_t sent = 0;  // the revision
  };
  void subscribe(const FoxgloveRequest::Subscription& wanted);
  void unsubscribe(std::uint32_t id);
  void complain(const std::string& message);
  void send(FoxgloveChannel channel, const FoxgloveScene& scene, Subscription& subscription);

  Viewer& viewer_;
  std::array<std::optional<Subscription>, kFoxgloveChannels> subscriptions_;
  std::vector<std::uint32_t> hands_;  // shown to the viewer, by rising number
};

}  // namespace feltwire::web
