#pragma once
// Simulates the moving objects of a scene. One thread owns a world; it shares nothing with other
// threads, and its time is the number of its steps.

#include <cstdint>
#include <memory>
#include <vector>

#include "core/dynamics/hand_speed_limit.hpp"
#include "core/dynamics/neighbour_list.hpp"
#include "core/local_model/local_model.hpp"
#include "core/scene/scene.hpp"
#include "core/tool/body_tool.hpp"

struct mjModel_;
struct mjData_;

namespace feltwire {

/// The state of a moving object for a tool: too far to be in the tool's list of neighbours, in the
/// list, or in the list and evaluated at the tool's last sample.
enum class NeighbourState : std::uint8_t { far, near, asked };

/// The largest recent force with which a hand pushed an object.
struct PeakPush {
  double force = 0.0;      // [N]
  std::uint64_t step = 0;  // of the world, then
};

/// The contacts of one tool with the moving objects after its last sample.
struct BodyContactState {
  std::size_t held = 0;  // the tool's place in Scene::views()
  Tool tool;
  std::vector<Vec3> forces;  // [N] on the hand, one for each moving object
  NeighbourList
      near;  // of a point or a ball: only these objects are evaluated; others give no force
  std::vector<NeighbourState> nearness;  // of a point or a ball: one for each moving object
  bool fresh = false;                    // made by the newest sample, with no step since
  std::uint64_t resets = 0;              // the world's, when the contact memory was last valid
  std::uint64_t steps = 0;               // the world's, when it was last asked
  double most_force = HandLimits::kOff;  // [N] limit, on all moving objects together
  HandSpeedLimit pace;
  bool placed = false;                // a sample has come
  std::vector<PeakPush> peak_pushes;  // one for each moving object

  // The rest is for a tool with a body. `tool` is then the pose at which the contacts hold it.
  Pose device;                        // the pose of the device
  std::vector<Vec3> torques;          // [N m] on the hand, about the tool's position
  std::vector<ObjectMotion> motions;  // of all objects, since it was last asked
  double ahead = 0.0;                 // [s] that the tool went through since the hand's last sample
};

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
  const ToolView& view(std::size_t held = 0) const { return *held_[held].view; }
  double tick() const { return tick_; }  // [s] time of one step
  /// The objects of that view; moving ones are at their present places.
  const std::vector<Object>& objects(std::size_t held = 0) const { return held_[held].objects; }
  /// [m/s] of the material point of an object that is at `point` [m, world].
  Vec3 velocity_at(std::size_t object, const Vec3& point) const noexcept;
  const WorldCounters& counters() const { return counters_; }
  /// True: the bodies were put back less than kRecovery ago.
  bool recovering() const { return trust_ < 1.0; }
  /// The share (0 to 1) of its force with which an object is felt: 1, and less for a moving object
  /// while recovering().
  double trust(std::size_t object) const { return object < still_ ? 1.0 : trust_; }
  /// So many ticks of time passed without a step, because the server could not keep up. The hands
  /// moved in that time.
  void let_pass(std::uint64_t ticks) noexcept { passed_ += ticks; }
  /// Continues in another scene that differs only in the materials of its objects
  /// (Scene::set_material). The scene must outlive the world.
  void adopt(const Scene& scene) noexcept;
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
  struct MovedView;
  void look() noexcept;
  bool sane() const noexcept;
  bool sane(std::size_t part) const noexcept;
  void find_broken(bool gave_up) noexcept;
  void go_back() noexcept;
  void forget_moving(BodyContactState& contacts, TouchMemory& memory) const noexcept;
  std::uint64_t time() const noexcept { return counters_.steps + passed_; }
  double way_of(const BodyContactState& contacts, const Pose& next) const noexcept;
  Command hold(const Pose& device, double elapsed, BodyMemory& memory,
               BodyContactState& contacts) const noexcept;
  void apply(std::size_t part, BodyContactState& contacts, const Vec3& at, double share) noexcept;
  void update_neighbours(const MovedView& held, const Vec3& position, TouchMemory& memory,
                         BodyContactState& contacts) const noexcept;
  void ask_near(const Tool& tool, TouchMemory& memory, BodyContactState& contacts,
                Command& sum) const noexcept;
  void ask(const MovedView& held, std::size_t part, const Tool& tool, TouchMemory& memory,
           BodyContactState& contacts, Command& sum) const noexcept;
  bool comes_near(const MovedView& held, std::size_t part, const Vec3& position,
                  const BodyContactState& contacts, FeatureMemory& memory) const noexcept;
  bool passes_by(const MovedView& held, std::size_t part, const Vec3& position,
                 FeatureMemory& memory) const noexcept;

  double tick_;
  std::size_t still_, parts_;  // objects that stand, that move
  struct Motion {
    Vec3 linear = Vec3::Zero();   // [m/s] of the object's origin
    Vec3 angular = Vec3::Zero();  // [rad/s]
  };
  std::vector<Motion> motions_;  // of those that move
  /// For a shape that must know from where a tool comes, in the shape's own frame (follows_way()).
  struct Followed {
    bool way = false;
    Pose before;  // a step ago
  };
  std::vector<Followed> followed_;
  /// The objects as one of the tools meets them. They are at the same places for all tools, but a
  /// mesh is triangles for a point and a grid for a body.
  struct MovedView {
    const ToolView* view;
    std::vector<Object> objects;
    NeighbourSearch reach;  // of those that move
  };
  std::vector<MovedView> held_;  // never empty
  double trust_ = 1.0;           // share of a moving object's force that is felt
  WorldCounters counters_;
  std::uint64_t passed_ = 0;                         // ticks that were not stepped
  std::uint64_t last_reset_ = 0, reset_before_ = 0;  // [steps]
  std::unique_ptr<Run> run_;
};

}  // namespace feltwire
