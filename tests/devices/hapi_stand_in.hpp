#pragma once
// A 2-dof open board at a pseudo terminal, with a simulated mass and scripted faults. Written from
// the published frames and geometry, not from the driver.

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tests/devices/force_edge.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// In virtual time: each frame of torques is a tick of 1 ms. The mass taps (its z) along the
/// pantograph's y, 80 mm from the shafts, and slides (its x) along the pantograph's x.
class HapiBoard {
 public:
  enum class Firmware { hapi, silent, talkative, other_device };

  HapiBoard();
  ~HapiBoard();
  HapiBoard(const HapiBoard&) = delete;
  HapiBoard& operator=(const HapiBoard&) = delete;

  /// The first call starts the board: set its mass and firmware before.
  const std::string& port();
  void unplug() { unplug_.store(true); }
  /// Stops the frames, so that the mass can be read.
  void stop();

  SimulatedMass mass;
  ForceEdge edge;
  Firmware firmware = Firmware::hapi;
  std::atomic<bool> blocks{false};        // the board does not read
  std::atomic<int> late{0};               // replies that come 30 ms late
  std::atomic<int> drops{0};              // replies that it omits
  std::atomic<int> loses{0};              // frames that it ignores
  std::atomic<int> garbles{0};            // replies with some changed bytes
  std::atomic<int> repeats{0};            // replies that it sends twice
  std::atomic<int> not_numbers{0};        // replies with angles that are NaN
  std::atomic<int> jumps{0};              // replies with an arm at another place
  std::atomic<double> force{0.0};         // [N] on the mass
  std::atomic<int> frames{0}, setups{0};  // those that it understood
  std::atomic<bool> unplugged{false};
  std::atomic<double> offset{0.0};  // [deg] from the first setup

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
