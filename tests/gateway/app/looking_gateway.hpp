#pragma once
// A gateway that observes a server over real sockets.

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "gateway/app/gateway.hpp"
#include "server/app/server.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/web/page_client.hpp"
#include "tests/support/security.hpp"

namespace feltwire::gateway_test {

using test::Page;

inline const IssuedToken& observer() {
  static const IssuedToken issued = issue_token("gateway", "*", Role::observer, std::nullopt);
  return issued;
}
/// The token for the gateway's own viewers, unknown to the server.
inline const IssuedToken& viewer() {
  static const IssuedToken issued = issue_token("eye", "*", Role::admin, std::nullopt);
  return issued;
}

inline std::vector<Scene> one(Scene scene) {
  std::vector<Scene> scenes;
  scenes.push_back(std::move(scene));
  return scenes;
}

inline Server server_at(std::uint16_t port = 0) {
  ServerConfig config = test::any_port();
  config.port = port;
  return {config, one(test::room(0.0)), test::security({observer().token})};
}

inline GatewayConfig config_for(std::uint16_t port) {
  GatewayConfig config;
  config.server = test::access(port, "127.0.0.1", observer().text);
  config.web = "0";
  config.log_level = "off";
  return config;
}

inline Gateway gateway_for(std::uint16_t port, Scene scene = test::room(0.0)) {
  return {config_for(port), one(std::move(scene)),
          Security{test::identity(), {}, TokenFile(Tokens{viewer().token})}};
}

inline Page page_of(const Gateway& gateway) { return {gateway, std::string(viewer().text.text())}; }

/// A hand at the place that the test sets.
class Hand {
 public:
  explicit Hand(const Server& server, const SessionParameters& parameters = {})
      : control_(server.control_port()),
        joined_(control_.join(test::join_request(parameters))),
        socket_(SOCK_DGRAM, joined_.udp_port),
        encoder_(test::Way::up, joined_.keys) {}
  void put(double z, double force = 0.0) {
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0] = test::hand(++packet_);
    batch.samples[0].pose.position = {-0.05, 0, z};
    batch.samples[0].held.elastic = {0, 0, force};
    batch.previous = packet_ - 1;
    batch.report = HandReport{.hand_damping = 1.5, .late_ticks = 5, .times = times_};
    socket_.send(encoder_.samples(joined_.accepted.session, packet_, batch));
    ASSERT_FALSE(socket_.receive().empty());
  }

  /// Reports its wake-ups and round trips; the first report starts the counting.
  void be_punctual(const HandTimes::Counts& wakeups, const HandTimes::Counts& round_trips) {
    times_ = HandTimes{};
    put(0.003);
    times_ = HandTimes{wakeups, round_trips};
    put(0.003);
  }

 private:
  std::optional<HandTimes> times_;
  test::ControlClient control_;
  test::JoinedBy joined_;
  test::RawSocket socket_;
  test::SealedEncoder encoder_;
  std::uint64_t packet_ = 0;
};

}  // namespace feltwire::gateway_test
