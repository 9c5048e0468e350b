#pragma once
// One viewer of the Foxglove protocol: what it has subscribed to, and what it was sent of it.

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
  /// Says at once what this server is and what there is to subscribe to. `viewer` outlives this.
  FoxgloveViewer(Viewer& viewer, std::string_view scene);

  /// A text message of the viewer. What cannot be done is said as a status; the connection stays.
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
  std::vector<std::uint32_t> hands_;  // that it was shown, by rising number
};

}  // namespace feltwire::web
