#pragma once
// One run of what moves in a scene. A world has one owner, the scene's host; nothing in it is
// shared, and time is the number of its steps.

#include <cstdint>
#include <memory>
#include <vector>

#include "core/dynamics/hand_pace.hpp"
#include "core/dynamics/neighbour_list.hpp"
#include "core/local_model/local_model.hpp"
#include "core/scene/scene.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {

/// Of a moving object to a tool: not in its list, in the list, or asked by its last sample.
enum class NeighbourState : std::uint8_t { far, near, asked };

/// The hardest that a hand pushed an object lately.
struct PeakPush {
  double force = 0.0;      // [N]
  std::uint64_t step = 0;  // of the world, then
};

/// One tool's hold on the moving objects: what it put on them last.
struct BodyContactState {
  std::size_t held = 0;  // which of the scene's tools it is (Scene::views())
  Tool tool;
  std::vector<Vec3> forces;  // [N] on the hand, one for each moving object
  NeighbourList near;        // of a point or a ball: these alone are asked; others have no force
  std::vector<NeighbourState> nearness;  // likewise, of each moving object
  bool fresh = false;                    // of the tool's newest sample, and no step since
  std::uint64_t resets = 0;              // of the world, that the contact memory knows of
  std::uint64_t steps = 0;               // of the world, when it was last asked
  double most_force = HandLimits::kOff;  // [N] on all moving objects together
  HandPace pace;
  bool placed = false;                // a sample has come
  std::vector<PeakPush> peak_pushes;  // one for each moving object

  // Of a tool with a body; `tool` is then where the scene holds it.
  Pose device;                        // where the hand holds it
  std::vector<Vec3> torques;          // [N m] with the forces, about the tool's position
  std::vector<ObjectMotion> motions;  // of all objects, since it was last asked
};

struct WorldCounters {
  std::uint64_t steps = 0;
  std::uint64_t resets = 0;    // back to the last good state, since a step was none
  std::uint64_t returned = 0;  // free bodies that were lost and put back where they began
  std::uint64_t warnings = 0;  // of MuJoCo: singular inertia, no room for a contact or constraint
};

class World {
 public:
  /// Starts as the scene does. The scene must outlive it and have a mechanism, else
  /// std::invalid_argument. Allocates; nothing else here does, but step() where what moves needs
  /// more room than ever before.
  explicit World(const Scene& scene);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// The scene as one of its tools touches it, by BodyContactState::held.
  const ToolView& view(std::size_t held = 0) const { return *held_[held].view; }
  double tick() const { return tick_; }  // [s] of a step
  /// That view's objects, those that move where they now are.
  const std::vector<Object>& objects(std::size_t held = 0) const { return held_[held].objects; }
  /// [m/s] of the material point of an object that is at `point` [m, world].
  Vec3 velocity_at(std::size_t object, const Vec3& point) const noexcept;
  const WorldCounters& counters() const { return counters_; }
  /// The bodies were put back less than kRecovery ago.
  bool recovering() const { return trust_ < 1.0; }
  /// Share of its force that an object is felt with: 1, of one that moves less while recovering().
  double trust(std::size_t object) const { return object < still_ ? 1.0 : trust_; }
  /// So many ticks of time have passed that are not stepped (the server could not keep up): hands
  /// have moved in them.
  void let_pass(std::uint64_t ticks) noexcept { passed_ += ticks; }
  /// Goes on in a scene that differs from this world's in the materials of its objects alone
  /// (Scene::set_material). The scene must outlive it.
  void adopt(const Scene& scene) noexcept;
  /// [m/s^2] on the bodies.
  Vec3 gravity() const;
  /// From the step after the next one on; a World that is made anew has the scene's.
  void set_gravity(const Vec3& gravity) noexcept;
  /// [N s] linear momentum of the bodies.
  Vec3 momentum() const noexcept;

  BodyContactState contact_state() const { return contact_state(view()); }
  /// Of a hand with the tool of this view. Throws std::invalid_argument where the view is not one
  /// of this world's scene.
  BodyContactState contact_state(const ToolView& view, const HandLimits& limits = {}) const;

  /// As ToolView::touch() of the view that the contacts were made for, with the moving objects
  /// where they are and as fast as they are. What they put on the hand is kept in `contacts`;
  /// push() puts the opposite on them. A hand that is faster than its limit since its last sample
  /// lets go of what moves, and both feel each other from nothing again, whole after kRecovery.
  Command touch(const Tool& tool, TouchMemory& memory, BodyContactState& contacts) const noexcept;
  /// Likewise as ToolView::touch() of a tool with a body.
  Command touch(const Pose& device, const Vec3& velocity, double elapsed, BodyMemory& memory,
                BodyContactState& contacts) const noexcept;

  /// Puts a share (0 to 1) of the contacts on the bodies for the next step. The first step after a
  /// sample takes exactly the forces that touch() answered with, negated, at the tool: Newton's
  /// third law, moments included. At a further one the hand is taken to stand where it was, and the
  /// forces are those that the bodies meet it with now: a force held on while the body moves would
  /// be a spring that answers late, and gain energy. Where the forces are together more than the
  /// hand's limit, all are scaled down alike, torques with them. A point or ball that has been
  /// pushed out of an object's ball of reach, with the surface behind it, pushes at the nearest
  /// point of that ball: no lever is longer than the object.
  void push(BodyContactState& contacts, TouchMemory& memory, double share) noexcept;
  void push(BodyContactState& contacts, BodyMemory& memory, double share) noexcept;

  /// Moves on by one tick, and takes the pushes away. False where the step came to nothing sane
  /// (MuJoCo gives up, numbers that are not finite, speeds that nothing here has): then the bodies
  /// are, at rest, where they were at least kGoodAge before, and farther back each time that is not
  /// good enough; and moving objects are felt from zero again, whole after kRecovery.
  bool step() noexcept;

  /// After a step() that came to nothing: how hard [N] that hand has pushed what broke, since the
  /// reset before and at most kBlameAge ago; 0: it had no part in it. What broke is each object
  /// that is not sane, with all that it hangs together with by joints or contacts; where MuJoCo
  /// gave up and does not say at what, it is everything.
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
  void look_round(const MovedView& held, const Vec3& position, TouchMemory& memory,
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
  /// Likewise, of what has to know where a tool comes from, seen from itself (follows_way()).
  struct Followed {
    bool way = false;
    Pose before;  // a step ago
  };
  std::vector<Followed> followed_;
  /// What hands meet that hold one of the tools: the same places for all, but what is triangles to
  /// a point is a grid to a body.
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
