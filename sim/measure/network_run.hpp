#pragma once
// A whole session in virtual time: hand, servo, datagrams, emulated link, server, and back. No
// socket and no clock; the same options give the same bits.

#include <optional>
#include <vector>

#include "client/emulated_link/link.hpp"
#include "client/hands/replay_device.hpp"
#include "client/hands/simulated_device.hpp"
#include "client/servo/servo.hpp"
#include "core/scene/scene.hpp"
#include "server/scene/scene_sessions.hpp"
#include "sim/hands/adversarial_hand.hpp"

namespace feltwire {

struct NetworkRunOptions {
  SimulatedHandOptions hand;  // the device, the arm behind it and its intended movement
  /// Moves the device instead of the hand, for every force: positions only. The device's numbers
  /// stay those of `hand.spec`.
  std::optional<Recording> recording;
  /// Moves the device instead of the hand, and takes as much energy as it can.
  std::optional<TakingTask> taking;
  /// The device's numbers for server and servo, if they are not the true ones.
  std::optional<DeviceSpec> told;
  SessionParameters parameters;
  ServoOptions servo;
  TwoWayLinkOptions link;
  double duration = 4.0;         // [s], longer than a servo period
  double silence_timeout = 2.0;  // [s] of the server, > 0
  /// A client with a local model has the scene in full as far as it can travel, as the real one
  /// does once it has fetched it (SceneFetch); false: it has patches and planes of it.
  bool whole_scene = true;
  bool timed = false;  // computing times are measured, by this machine's clock
};

/// A servo tick. Forces on the hand, world frame.
struct NetworkSample {
  double time = 0.0;             // [s] since the first tick
  Vec3 position = Vec3::Zero();  // [m] true, not rounded by encoders
  Vec3 velocity = Vec3::Zero();  // [m/s] true
  Vec3 acted = Vec3::Zero();     // [N] on the hand from the tick before to this one
  Quaternion orientation = Quaternion::Identity();  // true; the identity where it does not turn
  Command held;                                     // on the hand from this tick on
  Command ideal;                   // the scene's command for the true pose and velocity
  Command command;                 // the newest from the server, before fade and bound
  double command_age = 0.0;        // [s] since it came
  std::uint64_t sample_index = 0;  // of the sample that it answers; 0: none has come
};

struct DatagramCount {
  std::uint64_t datagrams = 0;
  std::uint64_t bytes = 0;  // sealed, header and tag included, with the 28 of UDP and IPv4 each
  /// Over `duration` [s].
  double kbit_per_second(double duration) const {
    constexpr double kKilobits = 8e-3;  // of a byte
    return kKilobits * static_cast<double>(bytes) / duration;
  }
};

struct NetworkRunResult {
  std::vector<NetworkSample> samples{};
  DatagramCount up{}, down{};  // sent into the link
  ServoStatistics servo{};
  std::array<std::uint64_t, kDropReasons> client_drops{};
  SceneCounters server{};
  LinkStatistics up_link{}, down_link{};
  ClockEstimate clock{};
  bool goodbye = false;  // the server ended the session
  /// Computing times of server and client, datagrams to datagrams and ticks without the device;
  /// zero unless requested. Only these numbers differ from run to run.
  Nanoseconds server_time{0}, client_time{0};

  /// The energy of the held forces at the port with the damping that the device really has: over
  /// the displacements that the encoders measured, which a bound knows; and over the true ones.
  PortEnergy measured_port, true_port;
  /// The energy by the client's own observer: as `measured_port`, with the dry friction that the
  /// account uses.
  PortEnergy observed_port;
  /// [J] least value over time of the energy that the device burned, with its Coulomb friction,
  /// less the energy that the hand got, over the true displacements and turns.
  double least_device_margin = 0.0;
  /// The energy at the true ends of the simulated hand's device, to the end. Its plant may hold
  /// another force than the one that was written, which the other energies here do not know.
  TrueEnergy true_energy{};
};

/// A tick every servo period from time 0 to `duration`. A datagram leaves the link when it is due,
/// also between ticks; the server answers it then; what is due at a tick is there before it. So a
/// link without delay answers the sample of one tick before the next.
/// Throws std::invalid_argument for what a session refuses or cannot be run.
NetworkRunResult run_network(const Scene& scene, const NetworkRunOptions& options);

}  // namespace feltwire
