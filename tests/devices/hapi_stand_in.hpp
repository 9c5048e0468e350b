#pragma once
// A 2-dof open board at a pseudo terminal, with a simulated mass at its pantograph and the faults
// that a test asks for. Written from the published frames and geometry, not from the driver.

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each frame of torques is a tick of a millisecond. The mass taps (its z) in the
/// pantograph's y, 80 mm from the shafts, and slides (its x) along them.
class HapiBoard {
 public:
  enum class Firmware { hapi, silent, talkative, other_device };

  HapiBoard();
  ~HapiBoard();
  HapiBoard(const HapiBoard&) = delete;
  HapiBoard& operator=(const HapiBoard&) = delete;

  /// From the first call on the board runs: set its mass and its firmware before.
  const std::string& port();
  void unplug() { unplug_.store(true); }
  /// No more frames: the mass can be looked at.
  void stop();

  SimulatedMass mass;
  ForceEdge edge;
  Firmware firmware = Firmware::hapi;
  std::atomic<bool> blocks{false};        // it does not read
  std::atomic<int> late{0};               // replies that come 30 ms late
  std::atomic<int> drops{0};              // replies that it will not give
  std::atomic<int> loses{0};              // frames that it will not see
  std::atomic<int> garbles{0};            // replies that it will give some of, with other bytes
  std::atomic<int> repeats{0};            // replies that it will give twice
  std::atomic<int> not_numbers{0};        // replies of angles that are none
  std::atomic<int> jumps{0};              // replies of an arm that is elsewhere
  std::atomic<double> force{0.0};         // [N] on the mass
  std::atomic<int> frames{0}, setups{0};  // that it understood
  std::atomic<bool> unplugged{false};
  std::atomic<double> offset{0.0};  // [deg] that the first setup asked for

 private:
  void run();
  void understand();
  void answer_setup();
  void answer_torques();
  void reply(const std::vector<std::uint8_t>& bytes);
  std::array<double, 2> arms() const;

  int board_ = -1, host_ = -1;
  std::string port_;
  std::vector<std::uint8_t> heard_;
  std::atomic<bool> over_{false}, unplug_{false};
  std::thread thread_;
};

}  // namespace stand_in
