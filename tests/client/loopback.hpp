#pragma once
// A whole server and its clients in one process, over real sockets of this machine.

#include <gtest/gtest.h>

#include <memory>
#include <sstream>
#include <thread>

#include "client/emulated_link/emulated_port.hpp"
#include "client/hands/replay_device.hpp"
#include "client/servo/servo_loop.hpp"
#include "tests/client/floor_server.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/security.hpp"

namespace feltwire::testing {

inline constexpr std::chrono::milliseconds kPatience{10'000};

/// Moves down, slides below the surface and moves up again, in 0.4 s.
inline const char* const kStroke =
    "t,x,y,z\n0,0,0,0.005\n0.1,0,0,-0.004\n0.3,0.02,0,-0.004\n0.4,0.02,0,0.005\n";

/// A port with an emulated link in front; null without a link.
inline std::unique_ptr<DatagramPort> linked(const Address& server,
                                            std::unique_ptr<TwoWayLink> link) {
  if (link == nullptr) return nullptr;
  return std::make_unique<EmulatedPort>(open_udp_port(server), std::move(*link));
}

/// A client with a device that replays rows.
struct Client {
  ReplayDevice device;
  Joined joined;
  Transport transport;
  Servo servo;
  Event stop;
  std::unique_ptr<LoopResult> result = std::make_unique<LoopResult>();
  Ring<TickRecord> records{1 << 14};
  Ring<TimedView> views{16};  // for an observer
  std::thread thread;

  Client(const ServerAccess& server, const char* rows, const SessionParameters& parameters,
         const std::string& scene, std::unique_ptr<TwoWayLink> link = nullptr,
         const Address* by_way_of = nullptr, Role role = Role::operator_)
      : device(recording(rows), builtin_device("simulated")),
        joined(join(server, {"tester", scene, device.spec(), parameters, role}, kPatience)),
        transport({by_way_of != nullptr ? *by_way_of : joined.datagrams, joined.accepted.session,
                   joined.keys},
                  joined.accepted.parameters, false,
                  linked(by_way_of != nullptr ? *by_way_of : joined.datagrams, std::move(link))),
        servo(device.spec(), joined.accepted.parameters) {}
  ~Client() {
    stop.set();  // a failed test must not wait for the end of the recording
    finish();
  }

  void start(LoopOptions options = {.silence_timeout = kPatience}) {
    thread = std::thread([this, options] {
      run_servo_loop(device, servo, transport, options, stop, {.record = &records, .views = &views},
                     *result);
    });
  }
  const TwoWayLink* link() const {
    const auto* port = dynamic_cast<const EmulatedPort*>(&transport.port());
    return port != nullptr ? &port->link() : nullptr;
  }
  void finish() {
    if (thread.joinable()) thread.join();
  }
  /// The next recorded tick that meets the condition; older ticks are dropped.
  template <class Condition>
  TickRecord next_tick(const std::string& what, Condition condition) {
    TickRecord row;
    test::eventually(what, [&] { return records.pop(row) && condition(row); });
    return row;
  }
  static Recording recording(const char* rows) {
    std::istringstream in(rows);
    return read_recording(in, "rows");
  }
};

class Loopback : public ::testing::Test {
 protected:
  Loopback() {
    std::vector<Scene> scenes;
    scenes.push_back(floor_scene());
    server = std::make_unique<Server>(any_ports(), std::move(scenes), test::security());
    endpoint = test::access(server->control_port());
  }
  std::unique_ptr<Server> server;
  ServerAccess endpoint;
};

}  // namespace feltwire::testing
