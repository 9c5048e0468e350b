#include "client/simulator/simulator_session.hpp"

#include <cmath>
#include <stdexcept>

#include "client/simulator/simulator_port.hpp"
#include "core/build_info/build_info.hpp"
#include "protocol/crypto/aead.hpp"
#include "protocol/crypto/session_keys.hpp"

namespace feltwire {
namespace {

constexpr std::uint64_t kSession = 1;
/// With a force deadband a hand does not expect an answer to every sample. This one is smaller than
/// any force.
constexpr double kNoDeadband = 1e-12;
constexpr double kNeverSilent = 1e6;  // [s] the session of a simulator does not end by silence

void require(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

}  // namespace

std::shared_ptr<SimulatorFeed> meet_simulator(RunOptions& options, const SimulatorScene& scene) {
  require(scene.stiffness > 0.0 && scene.stiffness <= kStiffest,
          "stiffness must be above 0 and at most 1e9 N/m: that of the stiffest surface");
  require(scene.start_position.allFinite(), "start_position is not a number");
  require(std::abs(scene.start_normal.norm() - 1.0) < 1e-3, "start_normal is no unit vector");
  SessionParameters& wanted = options.parameters;
  require(wanted.side == BoundingSide::client, "side of --mode must be client: there is no server");
  require(!options.servo.leads, "--lead needs a server with a robot");
  wanted.local_model = true;
  wanted.force_deadband = kNoDeadband;
  wanted.keep_alive = 0.5 * wanted.hold_time;
  validate(wanted);
  options.whole_surfaces = false;

  auto feed = std::make_shared<SimulatorFeed>();
  constexpr CipherSuite kSuite = CipherSuite::chacha20_poly1305;
  require(supported(kSuite), "the library libsodium cannot start");
  const SessionKeys keys = random_session_keys(kSuite);
  options.hooks.join = [scene, keys](const control::JoinRequest& request) {
    Joined joined;
    joined.keys = keys;
    control::JoinAccepted& accepted = joined.accepted;
    accepted.session = kSession;
    accepted.parameters = request.parameters;
    accepted.silence_timeout = kNeverSilent;
    accepted.friction = true;
    accepted.rotation = request.device.rotation_sensed > 0;
    accepted.start_position = scene.start_position;
    accepted.start_normal = scene.start_normal;
    accepted.stiffness = scene.stiffness;
    accepted.suite = keys.suite;
    accepted.version = version();
    return joined;
  };
  options.hooks.open_port = [feed, keys](const Address&) -> std::unique_ptr<DatagramPort> {
    return std::make_unique<SimulatorPort>(kSession, keys, feed);
  };
  return feed;
}

}  // namespace feltwire
