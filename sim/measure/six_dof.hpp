#pragma once
// A simulated hand that moves and turns, in process and deterministic: the loop of
// sim/measure/experiment.hpp in six degrees of freedom.

#include <functional>
#include <optional>
#include <vector>

#include "client/hands/simulated_device.hpp"
#include "core/bounding/account.hpp"
#include "core/bounding/bounding.hpp"
#include "core/scene/scene.hpp"

namespace feltwire {

/// The force and torque on the hand for a pose of the device, `elapsed` [s] after the call before.
/// It keeps its own memory; a copy copies that.
using PoseEnvironment =
    std::function<Command(const Pose& device, const Vec3& velocity, double elapsed)>;

/// The scene for its first tool, which has a body. The scene must outlive it.
PoseEnvironment pose_environment(const Scene& scene);

/// The account of energy: force and torque as one port with one balance, or each with its own.
enum class Ports : std::uint8_t { one, two };

struct SixDofSetup {
  SimulatedHandOptions hand;  // `spec` actuates torque
  BoundingConfig bounding;
  const BoundingMethod* law = nullptr;   // replaces the method that bounding.mode names
  std::optional<AccountConfig> account;  // after the bound; empty: none
  Ports ports = Ports::one;              // of the account
  int delay = 0;                         // [T] a round trip
  double duration = 4.0;                 // [s]
};

/// A servo sample. Forces and torques on the hand.
struct SixDofSample {
  double time = 0.0;                 // [s]
  Pose pose;                         // true
  Vec3 displacement = Vec3::Zero();  // [m] as the encoders say
  Vec3 rotation = Vec3::Zero();      // [rad] as the encoders report
  Command commanded, rendered;       // f_e(n), f_d(n)
  Command held;                      // f_d(n-1), which acted during the movement
  bool in_debt = false;              // of the account
  TrueEnergy energy;                 // until now
};

/// Reads the device every T, asks the environment, bounds, writes; one sample each, from time 0 to
/// `duration`. Throws std::invalid_argument for a setup that cannot be run.
std::vector<SixDofSample> run_six_dof(const PoseEnvironment& environment, const SixDofSetup& setup);

/// Accounts of one device: of force and torque together, or of each.
class PortAccounts {
 public:
  /// Throws as PortAccount.
  PortAccounts(const AccountConfig& config, Ports ports);
  Command step(const BoundingStep& step) noexcept;
  void set_held(const Command& held) noexcept;
  bool in_debt() const noexcept;

 private:
  PortAccount first_;                  // of both, or of force
  std::optional<PortAccount> torque_;  // of torque alone
};

/// The energy of a port of six degrees of freedom.
struct SixDofEnergy {
  // [J] the largest delivered energy beyond the burned energy:
  double measured = 0.0;  // by damping and what dry friction the account is told of, over what the
                          // encoders say
  double real = 0.0;      // by damping and all dry friction, over the true movement
  double force = 0.0, torque = 0.0;  // as `measured`, for translation and for rotation alone
};
SixDofEnergy energy_made(const DeviceSpec& spec, const std::vector<SixDofSample>& samples,
                         double period);

}  // namespace feltwire
