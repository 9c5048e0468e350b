#include "client/hands/plant_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/splitmix.hpp"
#include "core/base/text.hpp"

namespace feltwire {
namespace {

constexpr double kPlantStep = 10e-6;           // [s] longest time step
constexpr double kShortestPlantStep = 0.2e-6;  // [s] shortest allowed time step
constexpr double kPhase = 0.1;     // [rad] largest phase change of the fastest spring per step
constexpr double kDecay = 0.05;    // largest relative decay of a velocity by damping per step
constexpr int kMostRounds = 30;    // largest number of iterations per step
constexpr double kSolved = 1e-14;  // relative velocity change that ends the iteration
constexpr double kStill = 1e-15;   // [m/s] absolute velocity change that ends the iteration
constexpr std::size_t kMemoryMargin = 5;  // number of stored errors beyond the reflex delay
constexpr std::uint64_t kNoiseSeed = 0x6e6f697365;

/// Returns the strain of a spring at the displacement `way`. The spring has a backlash of the given
/// width.
double beyond(double way, double width) noexcept {
  const double out = std::abs(way) - 0.5 * width;
  return out > 0.0 ? std::copysign(out, way) : 0.0;
}

/// Returns a uniform random number in (0, 1].
double even(std::uint64_t seed, std::uint64_t i) noexcept {
  return 0x1p-53 * (static_cast<double>(splitmix::draw(seed, i) >> 11U) + 1.0);
}

double largest(const Vec3& v) noexcept { return v.cwiseAbs().maxCoeff(); }

/// Sums of the stiffness and damping of all springs and dampers at a body, and its mass.
struct Pull {
  double stiffness = 0.0, damping = 0.0, mass = 0.0;
};

/// Returns the longest accurate time step for a body [s]. The factor 2 allows for the motion of the
/// neighbour bodies.
double step_for(const Pull& body) {
  const double fastest = std::sqrt(2.0 * body.stiffness / body.mass);
  double step = kPlantStep;
  if (fastest > 0.0) step = std::min(step, kPhase / fastest);
  if (body.damping > 0.0) step = std::min(step, kDecay * body.mass / body.damping);
  return step;
}

}  // namespace

PlantMotion::PlantMotion(const Plant& plant, const DeviceSpec& spec, const Hand& hand)
    : plant_(plant),
      damping_(spec.damping),
      dry_(spec.coulomb_friction),
      arm_(hand),
      // A massless hand has no finger pad.
      pad_(plant.hand.has_pad() && hand.mass > 0.0),
      handle_(plant.transmission.rigid() ? kMotor : kMotor + 1),
      hand_body_(pad_ ? handle_ + 1 : handle_),
      count_(hand_body_ + 1),
      longest_step_(kPlantStep),
      amplifier_(plant.amplifier, plant.seed) {
  validate(plant, spec);
  const Plant::Transmission& t = plant.transmission;
  mass_[kMotor] += spec.apparent_mass - t.handle_mass;
  mass_[handle_] += t.handle_mass;
  mass_[hand_body_] += hand.mass;

  double most_share = plant.hand.grip.empty() ? 1.0 : 0.0;
  for (const Plant::Grip& grip : plant.hand.grip) most_share = std::max(most_share, grip.share);
  std::array<Pull, kBodies> pulls{};
  const auto between = [&](std::size_t a, std::size_t b, double stiffness, double damping) {
    if (a == b) return;
    for (const std::size_t body : {a, b}) {
      pulls[body].stiffness += stiffness;
      pulls[body].damping += damping;
    }
  };
  if (!t.rigid()) between(kMotor, handle_, t.stiffness, t.damping);
  if (pad_)
    between(handle_, hand_body_, most_share * plant.hand.pad_stiffness,
            most_share * plant.hand.pad_damping);
  pulls[kMotor].damping += damping_.matrix().cwiseAbs().rowwise().sum().maxCoeff();
  pulls[hand_body_].stiffness += most_share * hand.stiffness + plant.hand.reflex_stiffness;
  pulls[hand_body_].damping += most_share * hand.damping + plant.hand.reflex_damping;
  for (std::size_t i = 0; i < count_; ++i) {
    pulls[i].mass = mass_[i];
    longest_step_ = std::min(longest_step_, step_for(pulls[i]));
  }
  if (!(longest_step_ >= kShortestPlantStep)) {
    std::string why;
    append(why,
           "with these masses a part moves within %.2g s, and the shortest step is %.2g s; give a "
           "heavier handle, a softer transmission or less damping, or leave it out: rigid",
           longest_step_ / kPhase, kShortestPlantStep);
    throw PlantError(t.rigid() ? "hand.pad_stiffness" : "transmission.stiffness", why);
  }
  if (plant.hand.has_reflex())
    memory_.resize(static_cast<std::size_t>(plant.hand.reflex_delay / kMemoryStep) + kMemoryMargin);
  share_ = grip(0.0);
  place(Vec3::Zero());
}

void PlantMotion::place(const Vec3& position) noexcept {
  position_.fill(position);
  velocity_.fill(Vec3::Zero());
  arm_error_.setZero();
}

double PlantMotion::grip(double time) const noexcept {
  const std::vector<Plant::Grip>& grips = plant_.hand.grip;
  if (grips.empty()) return 1.0;
  if (time <= grips.front().time) return grips.front().share;
  for (std::size_t i = 1; i < grips.size(); ++i) {
    if (time >= grips[i].time) continue;
    const Plant::Grip &a = grips[i - 1], &b = grips[i];
    return a.share + (b.share - a.share) * (time - a.time) / (b.time - a.time);
  }
  return grips.back().share;
}

/// Returns the reflex force. It depends on the position error at the earlier time `time` -
/// reflex_delay, interpolated between two stored errors.
Vec3 PlantMotion::reflex(double time) noexcept {
  const double at = (time - plant_.hand.reflex_delay) / kMemoryStep;
  if (!(at >= 0.0)) return Vec3::Zero();
  const auto before = static_cast<std::uint64_t>(at);
  const double share = at - static_cast<double>(before);
  const Error& a = memory_[before % memory_.size()];
  const Error& b = memory_[(before + 1) % memory_.size()];
  const Vec3 way = (1.0 - share) * a.way + share * b.way;
  const Vec3 rate = (1.0 - share) * a.rate + share * b.rate;
  return plant_.hand.reflex_stiffness * way + plant_.hand.reflex_damping * rate;
}

void PlantMotion::remember(double time, const Vec3& error, const Vec3& rate) noexcept {
  while (static_cast<double>(remembered_) * kMemoryStep <= time)
    memory_[remembered_++ % memory_.size()] = {error, rate};
}

/// Computes the transmission force. The spring force is the change of the spring's energy divided
/// by the change of its length. So a time step across the edge of the backlash conserves the
/// energy.
void PlantMotion::strain_transmission(const Bodies& moved, double span,
                                      Forces& forces) const noexcept {
  const Plant::Transmission& t = plant_.transmission;
  const Vec3 before = position_[kMotor] - position_[handle_];
  const Vec3 change = moved[kMotor] - moved[handle_];
  for (int axis = 0; axis < 3; ++axis) {
    const double d0 = beyond(before[axis], t.backlash);
    const double d1 = beyond(before[axis] + change[axis], t.backlash);
    double spring = 0.5 * t.stiffness * (d0 + d1), damper = t.damping * change[axis] / span;
    if (t.backlash > 0.0) {
      // Share of the movement in which the spring is strained.
      double share = d0 * d1 > 0.0 ? 1.0 : 0.0;
      if (share == 0.0 && change[axis] != 0.0)
        share = std::clamp((d1 - d0) / change[axis], 0.0, 1.0);
      spring *= share;
      damper *= share;
      // At the edge of the backlash the parts can only push, so limit the damper force.
      if (spring * (spring + damper) <= 0.0) damper = -spring;
    }
    forces.transmission_spring[axis] = spring;
    forces.transmission[axis] = spring + damper;
  }
}

PlantMotion::Forces PlantMotion::forces(const Bodies& moved, const Drive& drive) const noexcept {
  Forces forces;
  if (handle_ != kMotor) strain_transmission(moved, drive.step, forces);
  if (pad_) {
    const Vec3 squeezed = position_[handle_] - position_[hand_body_];
    const Vec3 change = moved[handle_] - moved[hand_body_];
    forces.pad = drive.grip() * (plant_.hand.pad_stiffness * (squeezed + 0.5 * change) +
                                 plant_.hand.pad_damping / drive.step * change);
  }
  const Vec3 change = drive.intended_way - moved[hand_body_];
  forces.arm = drive.grip() *
               (arm_.stiffness * (drive.error + 0.5 * change) + arm_.damping / drive.step * change);
  return forces;
}

/// Returns the velocities after the step. Sets forces.dry, the dry friction at the motor, limited
/// to `most_dry`.
PlantMotion::Bodies PlantMotion::accelerated(Forces& forces, const Bodies& moved,
                                             const Drive& drive,
                                             const Vec3& most_dry) const noexcept {
  Bodies pull{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  pull[kMotor] += drive.motor - damping_.matrix() * moved[kMotor] / drive.step;
  if (handle_ != kMotor) {
    pull[kMotor] -= forces.transmission;
    pull[handle_] += forces.transmission;
  }
  if (pad_) {
    pull[handle_] -= forces.pad;
    pull[hand_body_] += forces.pad;
  }
  pull[hand_body_] += forces.arm + drive.reflex;
  Bodies velocity = velocity_;
  for (std::size_t i = 0; i < count_; ++i) velocity[i] += drive.step / mass_[i] * pull[i];
  const double impulse = drive.step / mass_[kMotor];  // [s/kg] velocity change per force
  for (int axis = 0; axis < 3; ++axis) {
    double& v = velocity[kMotor][axis];
    forces.dry[axis] = -std::clamp(v / impulse, -most_dry[axis], most_dry[axis]);
    v = std::abs(v) > impulse * most_dry[axis] ? v + impulse * forces.dry[axis] : 0.0;
  }
  return velocity;
}

Vec3 PlantMotion::most_dry_friction() const noexcept {
  const Plant::Friction& f = plant_.friction;
  if (!(f.breakaway > dry_)) return Vec3::Constant(dry_);
  Vec3 most;
  for (int axis = 0; axis < 3; ++axis) {
    const double v = velocity_[kMotor][axis] / f.stribeck_velocity;
    most[axis] = dry_ + (f.breakaway - dry_) * std::exp(-v * v);
  }
  return most;
}

double PlantMotion::spring_energy(double share, const Vec3& error) const noexcept {
  double energy = 0.5 * share * arm_.stiffness * error.squaredNorm();
  if (pad_)
    energy += 0.5 * share * plant_.hand.pad_stiffness *
              (position_[handle_] - position_[hand_body_]).squaredNorm();
  return energy;
}

double PlantMotion::stored() const noexcept {
  double energy = spring_energy(share_, arm_error_);
  for (std::size_t i = 0; i < count_; ++i) energy += 0.5 * mass_[i] * velocity_[i].squaredNorm();
  if (handle_ == kMotor) return energy;
  const Vec3 way = position_[kMotor] - position_[handle_];
  for (const double axis : way) {
    const double strained = beyond(axis, plant_.transmission.backlash);
    energy += 0.5 * plant_.transmission.stiffness * strained * strained;
  }
  return energy;
}

/// Adds the work of the forces over the displacements `moved` to flow_.
void PlantMotion::count(const Forces& forces, const Bodies& moved, const Bodies& velocity,
                        const Drive& drive) noexcept {
  const Vec3& hand = moved[hand_body_];
  flow_.given += drive.motor.dot(moved[kMotor]);
  flow_.burned += damping_.quadratic(moved[kMotor]) / drive.step - forces.dry.dot(moved[kMotor]);
  // Without a finger pad, the contact force is the force that accelerates the hand's mass.
  const Vec3 held =
      pad_ ? forces.pad
           : Vec3(arm_.mass / drive.step * (velocity[hand_body_] - velocity_[hand_body_]) -
                  forces.arm - drive.reflex);
  flow_.to_hand += held.dot(moved[handle_]);
  flow_.by_arm += forces.arm.dot(drive.intended_way) + drive.reflex.dot(hand);
  const double dampers = drive.grip() / drive.step;
  flow_.lost += dampers * arm_.damping * (drive.intended_way - hand).squaredNorm();
  if (pad_) flow_.lost += dampers * plant_.hand.pad_damping * (moved[handle_] - hand).squaredNorm();
  if (handle_ != kMotor)
    flow_.lost +=
        (forces.transmission - forces.transmission_spring).dot(moved[kMotor] - moved[handle_]);
}

void PlantMotion::step(double begin, double span, const Vec3& intended,
                       const Vec3& velocity) noexcept {
  Drive drive{.step = span,
              .motor = amplifier_.mean(begin, span),
              .reflex = Vec3::Zero(),
              .error = intended - position_[hand_body_],
              .intended_way = span * velocity,
              .grip_before = share_,
              .grip_after = grip(begin + span)};
  if (!memory_.empty()) {
    remember(begin, drive.error, velocity - velocity_[hand_body_]);
    drive.reflex = reflex(begin + 0.5 * span);
  }
  const Vec3 most_dry = most_dry_friction();
  Bodies after = velocity_, moved = velocity_;
  Forces acting;
  for (int round = 0; round < kMostRounds; ++round) {
    for (std::size_t i = 0; i < count_; ++i) moved[i] = 0.5 * span * (velocity_[i] + after[i]);
    acting = forces(moved, drive);
    const Bodies better = accelerated(acting, moved, drive, most_dry);
    double change = 0.0, speed = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      change = std::max(change, largest(better[i] - after[i]));
      speed = std::max(speed, largest(better[i]));
    }
    after = better;
    if (change <= kSolved * speed + kStill) break;
  }
  count(acting, moved, after, drive);
  const bool grips = drive.grip_after != drive.grip_before;
  const double loose = grips ? spring_energy(drive.grip_before, drive.error) : 0.0;
  const double mean_loose = grips ? spring_energy(drive.grip(), drive.error) : 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    position_[i] += moved[i];
    velocity_[i] = after[i];
  }
  arm_error_ = drive.error + drive.intended_way - moved[hand_body_];
  share_ = drive.grip_after;
  // A tighter grip stiffens strained springs. The arm supplies this energy.
  if (grips)
    flow_.by_arm += spring_energy(share_, arm_error_) - loose -
                    (spring_energy(drive.grip(), arm_error_) - mean_loose);
}

Vec3 PlantMotion::measured() noexcept {
  Vec3 at = plant_.encoder.side == EncoderSide::motor ? motor_position() : handle_position();
  if (!(plant_.encoder.noise > 0.0)) return at;
  for (double& axis : at) {  // Box-Muller transform
    const double radius = std::sqrt(-2.0 * std::log(even(plant_.seed ^ kNoiseSeed, noises_++)));
    const double angle = 2.0 * std::numbers::pi * even(plant_.seed ^ kNoiseSeed, noises_++);
    axis += plant_.encoder.noise * radius * std::cos(angle);
  }
  return at;
}

}  // namespace feltwire
