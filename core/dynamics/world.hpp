#pragma once
// Simulates the moving objects of a scene. One thread owns a world; it shares nothing with other
// threads, and its time is the number of its steps.

#include <cstdint>
#include <memory>
#include <vector>

#include "core/dynamics/body_contact_state.hpp"
#include "core/dynamics/moving_objects.hpp"
#include "core/scene/scene.hpp"

struct mjModel_;
struct mjData_;

namespace feltwire {

struct WorldCounters {
  std::uint64_t steps = 0;
  std::uint64_t resets = 0;    // times that it returned to an older state after a bad step
  std::uint64_t returned = 0;  // free bodies that went too far and were put back at their start
  std::uint64_t warnings = 0;  // MuJoCo's: singular inertia, no room for a contact or constraint
};

class World {
 public:
  /// Starts with the bodies at their places in the scene. The scene must outlive the world. Throws
  /// std::invalid_argument if the scene has no mechanism. It allocates. No other function
  /// allocates, except step() if the contacts need more room than ever before.
  explicit World(const Scene& scene);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// The scene for one of its tools; `held` as in BodyContactState.
  const ToolView& view(std::size_t held = 0) const { return *objects_.views()[held].view; }
  double tick() const { return tick_; }  // [s] time of one step
  /// The objects of that view; moving ones are at their present places.
  const std::vector<Object>& objects(std::size_t held = 0) const {
    return objects_.views()[held].objects;
  }
  /// [m/s] of the material point of an object that is at `point` [m, world].
  Vec3 velocity_at(std::size_t object, const Vec3& point) const noexcept {
    return objects_.velocity_at(object, point);
  }
  const WorldCounters& counters() const { return counters_; }
  /// True: the bodies were put back less than kRecovery ago.
  bool recovering() const { return trust_ < 1.0; }
  /// The share (0 to 1) of its force with which an object is felt: 1, and less for a moving object
  /// while recovering().
  double trust(std::size_t object) const { return object < objects_.still() ? 1.0 : trust_; }
  /// So many ticks of time passed without a step, because the server could not keep up. The hands
  /// moved in that time.
  void let_pass(std::uint64_t ticks) noexcept { passed_ += ticks; }
  /// Continues in another scene that differs only in the materials of its objects
  /// (Scene::set_material). The scene must outlive the world.
  void adopt(const Scene& scene) noexcept { objects_.adopt(scene); }
  /// [m/s^2] on the bodies.
  Vec3 gravity() const;
  /// Takes effect from the step after the next one. A new World starts with the scene's gravity.
  void set_gravity(const Vec3& gravity) noexcept;
  /// [N s] linear momentum of the bodies.
  Vec3 momentum() const noexcept;
  /// For motors of an MJCF file (core/arm): MuJoCo's model, which lives as long as the world, and
  /// its state, evaluated (mj_step1), until the next step. Only `ctrl` may be changed.
  const mjModel_& model() const noexcept;
  mjData_& state() noexcept;

  BodyContactState contact_state() const { return contact_state(view()); }
  /// The contacts of a hand before its first touch, with the tool of this view. Throws
  /// std::invalid_argument if the view is not of this world's scene.
  BodyContactState contact_state(const ToolView& view, const HandLimits& limits = {}) const;

  /// As ToolView::touch() of the view that `contacts` was made for, with the moving objects at
  /// their present poses and velocities. `contacts` keeps the force of each moving object on the
  /// hand; push() puts the opposite force on the object. Where a hand moved faster than its limit
  /// since its last sample, it lets go of the moving objects. The force between them then begins at
  /// zero and is whole again after kRecovery.
  Command touch(const Tool& tool, TouchMemory& memory, BodyContactState& contacts) const noexcept;
  /// As above, for a tool with a body.
  Command touch(const Pose& device, const Vec3& velocity, double elapsed, BodyMemory& memory,
                BodyContactState& contacts) const noexcept;

  /// Puts a share (0 to 1) of the contacts on the bodies for the next step. In the first step after
  /// a sample, these are exactly the forces of touch(), negated, at the tool (Newton's third law,
  /// with the moments). In each further step the hand is assumed to stand still, and the forces are
  /// computed for the new places of the bodies: a force that is held while the body moves would be
  /// a late spring, and a late spring makes energy. If the sum of the forces is more than the
  /// hand's limit, all forces and torques are scaled down by one factor. If a point or ball was
  /// pushed out of an object's ball of reach and the surface is behind it, it pushes at the nearest
  /// point of that ball, so that no lever is longer than the object.
  void push(BodyContactState& contacts, TouchMemory& memory, double share) noexcept;
  void push(BodyContactState& contacts, BodyMemory& memory, double share) noexcept;

  /// Simulates one tick, and then removes the pushes. False: the step was bad (MuJoCo gave up, a
  /// number is not finite, or a body is faster than kLargestSpeed or kLargestTurn). Then the bodies
  /// are put back, at rest, to where they were at least kGoodAge before, and farther back each time
  /// that the step after it is bad again. The force of moving objects then begins at zero and is
  /// whole again after kRecovery.
  bool step() noexcept;

  /// After a bad step(): the largest force [N] by which that hand pushed an object that broke,
  /// since the reset before and at most kBlameAge ago; 0: the hand had no part in it. The objects
  /// that broke are those with bad numbers and all that are connected to them by joints or
  /// contacts. Where MuJoCo gave up without saying where, they are all objects.
  double blame(const BodyContactState& contacts) const noexcept;

  static constexpr double kBlameAge = 0.1;        // [s]
  static constexpr double kGoodAge = 0.2;         // [s]
  static constexpr double kRecovery = 0.5;        // [s]
  static constexpr double kLargestSpeed = 100.0;  // [m/s] of a body
  static constexpr double kLargestTurn = 1000.0;  // [rad/s]
  static constexpr double kLost = 100.0;          // [m] from where it began, a free body is lost

 private:
  struct Run;
  WorldMoment moment() const noexcept;
  void look() noexcept;
  bool sane() const noexcept;
  bool sane(std::size_t part) const noexcept;
  void find_broken(bool gave_up) noexcept;
  void go_back() noexcept;
  void apply(std::size_t part, BodyContactState& contacts, const Vec3& at, double share) noexcept;

  double tick_;
  MovingObjects objects_;
  double trust_ = 1.0;  // share of a moving object's force that is felt
  WorldCounters counters_;
  std::uint64_t passed_ = 0;                         // ticks that were not stepped
  std::uint64_t last_reset_ = 0, reset_before_ = 0;  // [steps]
  std::unique_ptr<Run> run_;
};

}  // namespace feltwire
