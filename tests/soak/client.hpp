#pragma once
// A client that lives, changes ports and dies at random, repeatedly. Its servo's clock advances by
// a period per tick, so a slow machine makes it slow, not late. Every port must therefore keep
// what the bound promises for holds of one period.

#include <memory>
#include <vector>

#include "client/hands/simulated_device.hpp"
#include "client/servo/servo.hpp"
#include "client/transport/control_client.hpp"
#include "client/transport/datagram_session.hpp"
#include "core/base/splitmix.hpp"
#include "tests/server/raw_socket.hpp"

namespace feltwire::soak {

/// The counts over all lives.
struct Account {
  std::uint64_t lives = 0, left = 0, died = 0, roamed = 0;
  std::uint64_t refused = 0;  // joins
  std::uint64_t ticks = 0, samples = 0, replies = 0, with_force = 0;
  std::uint64_t violations = 0;     // at the ports, by the clients' own measurement
  std::uint64_t sent_away = 0;      // goodbyes to living clients
  std::uint64_t misaddressed = 0;   // datagrams at a port of another session
  std::uint64_t dropped = 0;        // invalid datagrams in the own session
  std::uint64_t faulty_forces = 0;  // commands beyond the device's limit, or not finite
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

  /// A servo tick and all else that is due now. Blocks during a join.
  void tick(Nanoseconds now);

  /// The end of the test: leaves or dies, and does not come back.
  void end(Nanoseconds now);
  /// Checks the abandoned ports: each may still receive datagrams of its own session only.
  void watch_old_ports(Nanoseconds now);
  /// Closes the abandoned ports.
  void forget() { old_ports_.clear(); }

 private:
  struct Life;
  struct OldPort {
    std::unique_ptr<test::RawSocket> socket;
    std::uint64_t session = 0;
    Nanoseconds until{};  // then the server has forgotten it; another client may get the port
  };

  /// A value from 0 to 1.
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
  std::unique_ptr<Life> life_;  // null between two lives
  Nanoseconds next_birth_{};
  std::vector<OldPort> old_ports_;
};

}  // namespace feltwire::soak
