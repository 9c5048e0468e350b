#pragma once
// The inputs and outputs of a bilateral teleoperation law of three degrees of freedom, at both
// ends.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "core/base/types.hpp"
#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "sim/teleoperation_laws/remote_ends.hpp"
#include "sim/teleoperation_laws/teleoperation_law.hpp"

namespace feltwire::teleop {

/// All values that a law may send; each uses some of them. Forces as F at the leader (resists the
/// hand).
struct SpatialDatagram {
  std::uint64_t index = 0;            // of the sender's servo sample
  double time = 0.0;                  // [s] when it was sent; the clocks of both ends agree
  std::array<Datagram, 3> axes = {};  // of a law that works on each coordinate
  Vec3 position = Vec3::Zero();       // [m]
  Vec3 velocity = Vec3::Zero();       // [m/s]
  Vec3 force = Vec3::Zero();          // [N]
  double energy = 0.0;                // [J] total that was sent, of a tank
  bool touching = false;              // the robot senses a force
  EnergyCounters counted = {};        // of the follower
  RemoteContact contact = {};         // that the follower estimates
  OtherSurfaces others = {};          // the same
  LeaderState wanted = {};            // of feltwire's law
};

struct SpatialLeaderSample {
  double time = 0.0;             // [s]
  Vec3 position = Vec3::Zero();  // [m] as the encoder reports
  Vec3 velocity = Vec3::Zero();  // [m/s] low-passed at 60 Hz
};
struct SpatialFollowerSample {
  double time = 0.0;
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();  // [m], [m/s] of the robot's tip
  Vec3 force = Vec3::Zero();                              // [N] on the robot, from its sensor
};

/// The output of a robot's servo until the next sample: force + damping (reference - v), as in
/// FollowerForce.
struct SpatialFollowerForce {
  Vec3 force = Vec3::Zero();      // [N]
  double damping = 0.0;           // [N s/m] the same in every direction
  Vec3 reference = Vec3::Zero();  // [m/s]
};

/// A law, both ends, called as TeleoperationLaw is.
class SpatialLaw {
 public:
  SpatialLaw() = default;
  SpatialLaw(const SpatialLaw&) = delete;
  SpatialLaw& operator=(const SpatialLaw&) = delete;
  virtual ~SpatialLaw() = default;
  /// The force F [N] that resists the hand until the next sample.
  virtual Vec3 lead(const SpatialLeaderSample& sample, std::span<const SpatialDatagram> arrived,
                    SpatialDatagram& out) = 0;
  virtual SpatialFollowerForce follow(const SpatialFollowerSample& sample,
                                      std::span<const SpatialDatagram> arrived,
                                      SpatialDatagram& out) = 0;
  /// [m] the robot's wanted place is the hand's place less this.
  virtual Vec3 offset() const { return Vec3::Zero(); }
};

/// The surface near this place of the robot's tip, as a model of the environment has it.
using SurfaceModel = std::function<SurfacePrior(const Vec3& tip)>;

/// The law of three degrees of freedom with this name (laws.hpp has the names). Only
/// `feltwire_prior` uses the model. Throws std::invalid_argument as make_law() does.
std::unique_ptr<SpatialLaw> make_spatial_law(std::string_view name, const Plant& plant,
                                             const SurfaceModel& model);

}  // namespace feltwire::teleop
