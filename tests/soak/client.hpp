#pragma once
// A client that lives, moves house and dies at random, again and again. Its servo's clock advances
// by a period a tick: a machine that is too slow makes it slow, not late, so that what the bound
// promises for holds of a period can be asked of every port.

#include <memory>
#include <vector>

#include "client/devices/simulated_device.hpp"
#include "client/servo/servo.hpp"
#include "client/transport/control_client.hpp"
#include "client/transport/datagram_session.hpp"
#include "core/base/splitmix.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire::soak {

/// Of all lives.
struct Account {
  std::uint64_t lives = 0, left = 0, died = 0, roamed = 0;
  std::uint64_t refused = 0;  // joins
  std::uint64_t ticks = 0, samples = 0, replies = 0, with_force = 0;
  std::uint64_t violations = 0;     // at the ports, by the clients' own account
  std::uint64_t sent_away = 0;      // goodbyes to who was alive and well
  std::uint64_t misaddressed = 0;   // datagrams at a port of another session
  std::uint64_t dropped = 0;        // datagrams of the own session that were none
  std::uint64_t faulty_forces = 0;  // commands above what the device can, or not finite
  Histogram round_trip;             // [ns]
  std::string last_refusal;
};

struct ClientOptions {
  ServerAccess server;
  std::string scene;
  Nanoseconds period{};           // of the servo
  Nanoseconds silence_timeout{};  // of the server
  std::uint64_t seed = 0;         // of this client's fate
};

class Client {
 public:
  Client(const ClientOptions& options, Account& account);
  ~Client();
  Client(Client&&) noexcept;

  /// One servo tick, and whatever else happens now. Blocks for as long as a join takes.
  void tick(Nanoseconds now);

  /// The end of the test: leaves or dies, and does not come back.
  void end(Nanoseconds now);
  /// Looks at the ports that were left behind: what still comes there must be of their sessions.
  void watch_old_ports(Nanoseconds now);
  /// Closes all of them.
  void forget() { old_ports_.clear(); }

 private:
  struct Life;
  struct OldPort {
    std::unique_ptr<test::RawSocket> socket;
    std::uint64_t session = 0;
    Nanoseconds until{};  // then the server has forgotten it, and another may have the port
  };

  /// From 0 to 1.
  double draw() {
    return 0x1p-53 * static_cast<double>(splitmix::draw(options_.seed, draws_++) >> 11);
  }
  double draw(double low, double high) { return low + (high - low) * draw(); }
  SessionParameters parameters();
  void be_born(Nanoseconds now);
  void move_house(Nanoseconds now);
  void die(Nanoseconds now);
  void keep(std::unique_ptr<test::RawSocket> socket, Nanoseconds now);
  void receive(Nanoseconds now);

  ClientOptions options_;
  Account* account_;
  std::uint64_t draws_ = 0;
  std::unique_ptr<Life> life_;  // none: between two
  Nanoseconds next_birth_{};
  std::vector<OldPort> old_ports_;
};

}  // namespace feltwire::soak
