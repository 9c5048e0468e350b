#pragma once
// Estimates the surface that a robot touches, from the wrench at its tool and the path of the tool.

#include <cstdint>

#include "core/base/types.hpp"
#include "core/teleoperation/line_fit.hpp"
#include "core/teleoperation/remote_contact.hpp"
#include "core/teleoperation/surface_memory.hpp"
#include "core/teleoperation/surface_tracker.hpp"

namespace feltwire {

/// A surface that is known before it is touched, from a model of the environment: the one that is
/// nearest to the tool. The model may be wrong.
struct SurfacePrior {
  std::uint32_t key = 0;         // tells surfaces apart; 0: there is none near
  Vec3 point = Vec3::Zero();     // [m] on the surface, near the tool
  Vec3 normal = Vec3::UnitX();   // unit, towards the free side
  double stiffness = 0.0;        // [N/m] 50 to 1e6; else the first stiffness is taken
  double friction = 0.0;         // mu
  Vec3 velocity = Vec3::Zero();  // [m/s] of the surface
};

struct ContactEstimatorConfig {
  /// [N/m] of the robot's own controller. A surface is assumed to have as much until the force over
  /// the way shows another.
  double first_stiffness = 1000.0;
  double on = 0.2,
         off = 0.1;  // [N] force at which a contact begins, ends; above the sensor's noise
};

/// Estimates the surface. At each sample
///   normal     the direction of the force, without its part along a sliding motion that it is
///              against; for the first 0.1 s of a touch the direction of the whole impulse, and
///              later a slow low-pass; kept while a new touch still moves in or bounces, or the
///              surface springs back, because friction leans that force. A surface that was touched
///              for half a second keeps its normal when it is touched again
///   stiffness  slope of the force over the depth along the normal that is known by then, with the
///              depth's speed beside it (a damper), once the samples of a touch show at least
///              0.1 mm and explain 98 % of the force; it improves for half a second and is then
///              kept. Later a moving wall changes force and depth, too, and would be taken for a
///              stiffness. A touch that bounces before that is one touch.
///   place      tip + normal F / k, and its speed: SurfaceTracker. A surface under a tool that
///   slides
///              stands: what a curved one changes would be taken for its motion, and a hand that is
///              told so over a delay swings. A surface whose stiffness is not known yet stands,
///              too: a place that is computed with another stiffness moves as the force does
/// A touch continues if the force is missing for less than kApart: a sliding tool leaves the
/// surface for some samples, and nothing changes meanwhile. After that the surface recedes to the
/// tool where the tool finds no force, and after kSame it is forgotten. A touch within kSame of the
/// last surface is the same surface again.
///
/// A surface that was touched has left if the tool has felt no force for kLeft, and for the last
/// SurfaceMemory::kAbsent of it was as deep as where it last felt the force `on`: a surface that
/// stands would press there. This needs neither its place nor its stiffness. A tool that has
/// moved aside must be deeper by half of that way, because the normal may lean. A surface that has
/// left is told kAway behind the tool: nobody knows where it is, and a hand must not feel it there.
/// It keeps its number until it is forgotten. So a hand that meets it again feels it where it is.
/// It also keeps its stiffness: it moves, and a motion would be taken for a stiffness.
///
/// Surfaces that were touched before are remembered (SurfaceMemory), and told as others(). A force
/// that no friction leans (60 degrees off the normal) is of another surface: a remembered one, or a
/// new one. If the stiffness of the surface is not known yet, this needs a gap in the force: the
/// surface may be a load that the tool carries, and what pushes a load comes on top of its weight.
/// The way between two touches of a surface lies in it. So the normal is made perpendicular to it,
/// and a force along it counts as friction.
///
/// With a prior the surface exists before the touch, at the place of the model plus the correction
/// of its last touch. The touch starts from place, normal and stiffness of the prior, and corrects
/// them. A tool that finds no force behind the surface pushes it back; after kSame in all the prior
/// is ignored until it is another surface. A surface that the model does not have stays until the
/// tool is kSame away from it.
///
/// No function allocates, throws or reads a clock. A sample that is not finite is ignored.
class ContactEstimator {
 public:
  static constexpr double kSame = 20e-3;   // [m]
  static constexpr double kApart = 20e-3;  // [s]
  static constexpr double kLeft = 25e-3;   // [s] without a force; more than kApart
  static constexpr double kAway = 0.2;     // [m] a hand is not so far ahead of its robot

  explicit ContactEstimator(const ContactEstimatorConfig& config) : config_(config) {}

  struct Sample {
    Vec3 position = Vec3::Zero();  // [m] of the tool's tip
    Vec3 velocity = Vec3::Zero();  // [m/s]
    Vec3 force = Vec3::Zero();     // [N] of the environment on the tool
    double elapsed = 1e-3;         // [s] > 0 since the last sample
    SurfacePrior prior = {};       // what the model of the environment says; key 0: nothing
  };
  const RemoteContact& step(const Sample& sample) noexcept;

  const RemoteContact& contact() const noexcept { return told_; }
  /// Surfaces that were touched before and are still there, besides contact().
  const OtherSurfaces& others() const noexcept { return memory_.told(); }
  /// The number of the newest surface; numbers only grow.
  std::uint32_t newest() const noexcept { return counted_; }

 private:
  void estimate(const Sample& sample) noexcept;
  void watch(const Sample& sample, double force) noexcept;
  void tell(const Vec3& tip) noexcept;
  bool change(const Sample& sample, const Vec3& normal) noexcept;
  Vec3 way_within(const Sample& sample, double force) const noexcept;
  void begin(const Sample& sample) noexcept;
  void recede(const Sample& sample) noexcept;
  bool expect(const Sample& sample) noexcept;
  void estimate_normal(const Sample& sample, double force) noexcept;
  void estimate_stiffness(const Sample& sample, double force) noexcept;
  double height_of(const Sample& sample, double force) const noexcept;
  void estimate_place(const Sample& sample, double force) noexcept;

  /// The touch that goes on, or the last one.
  struct Touch {
    double time = 0.0;           // [s] so far
    bool known = false;          // it has shown the stiffness
    Vec3 origin = Vec3::Zero();  // [m] the tip where it began
    Vec3 within = Vec3::Zero();  // unit: lies in the surface; zero: no such direction is known
    double last_height = 0.0;    // [m] in the last sample of the fit
  };
  /// The time without a touch.
  struct Gap {
    double time = 0.0;         // [s] without a force
    double receded = 0.0;      // [m] of the surface since the last touch
    Vec3 felt = Vec3::Zero();  // [m] the tip where it last felt the force `on`
    double absent = 0.0;       // [s] in which nothing pressed although the tip was deeper
    bool left = false;         // the surface was touched, and has left
  };
  /// The surface of the prior.
  struct Expected {
    std::uint32_t key = 0;      // of the prior
    std::uint32_t surface = 0;  // its number here
    double shift = 0.0;         // [m] along its normal, correction by touches
    bool disproved = false;     // the tool moved through it
  };

  ContactEstimatorConfig config_;
  KnownSurface surface_;
  RemoteContact told_;  // the surface's contact, but kAway behind the tool if it has left
  SurfaceMemory memory_;
  LineFit fit_;
  std::uint32_t counted_ = 0;
  bool pressed_ = false;  // the force is beyond the thresholds, on a known surface or not
  Touch touch_;
  Gap gap_;
  bool moves_ = false;    // the surface had left before this touch: it moves
  SurfaceTracker place_;  // along the normal
  Expected expected_;
};

}  // namespace feltwire
