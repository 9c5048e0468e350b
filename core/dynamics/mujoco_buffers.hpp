#pragma once
// Internal to core/dynamics: one run of a model, with the memory that it needs. MuJoCo allocates
// all memory beforehand, by three numbers. If they are too small, it drops contacts or fails.

#include <string>
#include <vector>

#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire::mujoco {

/// MuJoCo's three numbers (mjModel: nconmax, njmax, nstack).
struct BufferSizes {
  int contacts = 0;
  int rows = 0;   // of constraints: a contact has one for each dimension of its friction
  int stack = 0;  // numbers
};

/// [bytes] The memory of the contacts and constraints.
double bytes(const mjModel& model, const BufferSizes& room);

/// Marks a model just loaded, so that a Simulation chooses its room (nconmax 0); a <size> in its
/// file stays. After that only a Simulation may run it.
void leave_room_open(mjModel& model);

/// The room that a model begins with: for every moving geom as many contacts as it takes to rest,
/// in at most kFirstMemory.
BufferSizes first_room(const mjModel& model);

/// Whether the body's joint has a limited range.
bool has_range(const Body& body);

/// Newton's solver has matrices over the speeds of all bodies. With more bodies than this,
/// conjugate gradients are faster, for all contacts.
inline constexpr std::size_t kFewBodies = 200;

/// The <size> of a model with these objects and bodies, for the single step of MuJoCo's loader. A
/// Simulation chooses its own sizes. Throws std::invalid_argument if MuJoCo's numbers cannot be so
/// large.
std::string trial_room(std::size_t objects, const std::vector<Body>& bodies);

/// [bytes]
inline constexpr double kFirstMemory = 8e6, kMostMemory = 1e9;

/// A state of a model, and its steps. When a step runs out of room, the room is doubled and the
/// step is done again, with the same result as if it had been there before. At `most_memory` the
/// contacts that do not fit are left out and counted.
class Simulation {
 public:
  /// Evaluates the model's first state, `start` as for make_data(). Throws std::runtime_error if
  /// MuJoCo cannot. The model must outlive it. Sizes in the model's file stay.
  explicit Simulation(const mjModel& model, double most_memory = kMostMemory,
                      const std::vector<mjtNum>& start = {});

  const mjModel& model() const { return model_; }
  mjData* data() const { return data_.get(); }
  /// Whether there are more contacts than the memory may hold.
  bool is_full() const { return full_; }
  Vec3 gravity() const;  // [m/s^2]
  /// Changes gravity in this run alone. The step under way is evaluated already, so the change acts
  /// from the next step on.
  void set_gravity(const Vec3& gravity) noexcept;
  BufferSizes room() const { return {model_.nconmax, model_.njmax, model_.nstack}; }

  /// mj_step1() evaluates the state, mj_step2() does a step. They return false if MuJoCo failed,
  /// and allocate only to grow.
  bool evaluate() noexcept;
  bool advance() noexcept;

 private:
  bool grow(bool out_of_stack) noexcept;
  bool is_crowded() const noexcept;

  mjModel model_;  // shallow: all but the sizes is the given one's
  Data data_;
  double most_memory_;  // [bytes] limit
  bool fixed_;          // the file sets the sizes
  bool full_ = false;
};

}  // namespace feltwire::mujoco
