#pragma once
// A service like Haply's on a port of this machine, with its own WebSocket code, each dialect of
// the JSON, a simulated mass and scripted faults. Written from the published messages, not from the
// driver.

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <thread>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each command is a tick of 1 ms. The service's axes are x right, y away, z up;
/// its origin is 0.12 m behind and 0.15 m below the mass's. The mass's axes are x near, y right, z
/// up.
class HaplyService {
 public:
  enum class Json { v3_0, v3_1, v3_5 };

  explicit HaplyService(Json json);
  ~HaplyService();
  HaplyService(const HaplyService&) = delete;
  HaplyService& operator=(const HaplyService&) = delete;

  std::uint16_t port() const { return port_; }
  /// Stops the commands, so that the mass can be read.
  void stop();

  SimulatedMass mass;
  ForceEdge edge;
  std::atomic<bool> plugged{true}, second{false}, speaks{true};
  // Set these before the driver connects.
  const char* permutation = "XYZ";
  double scale = 1.0, damping = 0.0;
  const char* handedness = "right";
  bool old_json = false;  // JSON of 2.x, known only as another dialect
  std::atomic<bool> ready{true}, power_supply{true}, in_use{false};
  std::atomic<bool> calibrated{true}, button{false}, second_button{false};
  std::atomic<bool> grip_turns{false};    // the grip reports its orientation
  std::atomic<double> away_turn{0.0};     // [rad] about the service's y, away from the user
  std::atomic<bool> wrong_length{false};  // the quaternion has a wrong length
  std::atomic<bool> blocks{false};        // the service does not read
  std::atomic<bool> hangs_up{false};      // the service closes the connection
  std::atomic<double> gate{1.0};          // share of the force that it applies and reports
  std::atomic<double> pushes{0.0};        // [N] along z from another program
  std::atomic<int> late{0};               // answers that come 30 ms late
  std::atomic<int> drops{0};              // answers that it omits
  std::atomic<int> breaks{0};             // answers that are not JSON
  std::atomic<int> huge{0};               // answers of 200 kB
  std::atomic<int> repeats{0};            // answers that it sends twice
  std::atomic<int> homeless{0};           // answers without a position
  std::atomic<bool> masks{false};         // it masks frames, which only clients may do
  std::atomic<unsigned> odd_bits{0};      // set in the first byte of each frame
  std::atomic<int> fragments{0};          // answers in three frames, with a ping between them
  std::atomic<int> pongs{0};
  std::atomic<double> force{0.0};  // [N] on the mass
  std::atomic<int> commands{0}, sessions{0}, misunderstood{0};
  std::atomic<int> for_second{0};  // commands to the second device, which shares the mass

 private:
  void run();
  bool shake_hands();
  void serve();
  void understand(std::string_view text);
  std::string told(bool first) const;
  std::string device(std::string_view id, bool first) const;
  void answer(std::string text);
  void send_frame(unsigned head, std::string_view text);
  bool fill(std::size_t size);

  Json json_;
  int listener_ = -1, peer_ = -1;
  std::uint16_t port_ = 0;
  std::string heard_;
  Three applied_{};  // [N] in the service's axes
  bool homed_ = true;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

}  // namespace stand_in
