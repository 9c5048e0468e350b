#pragma once
// Internal to core/scene: one run of a model, in as much memory as it needs. MuJoCo takes all of
// it beforehand, by three numbers; where these are too small it leaves contacts out or gives up.

#include <string>
#include <vector>

#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire::mujoco {

/// What MuJoCo's three numbers are (mjModel: nconmax, njmax, nstack).
struct Room {
  int contacts = 0;
  int rows = 0;   // of constraints: of a contact as many as its friction has dimensions
  int stack = 0;  // numbers
};

/// [bytes] that contacts and constraints take.
double bytes(const mjModel& model, const Room& room);

/// Says in a model just loaded (nconmax 0) that its room is to be chosen, unless its file has a
/// <size>. Nothing but a Simulation may run it then.
void leave_room_open(mjModel& model);

/// What a model begins with: for every geom that moves as many contacts as it rests on, in no more
/// than kFirstMemory.
Room first_room(const mjModel& model);

/// The body's joint has ends.
bool has_range(const Body& body);

/// Newton's solver has matrices of all speeds of all bodies; beyond so many bodies, whatever they
/// touch, conjugate gradients cost less.
inline constexpr std::size_t kFewBodies = 200;

/// The <size> of a model made of these, for the one step that MuJoCo's loader tries; a Simulation
/// chooses its room by itself. Throws std::invalid_argument where MuJoCo has no such room.
std::string trial_room(std::size_t objects, const std::vector<Body>& bodies);

/// [bytes]
inline constexpr double kFirstMemory = 8e6, kMostMemory = 1e9;

/// A state of a model, and its steps. Where room runs out it takes twice as much and does the step
/// again, as if it had had it before; at kMostMemory it leaves out what does not fit, and counts.
class Simulation {
 public:
  /// Evaluated where the model begins. Throws std::runtime_error where MuJoCo cannot. The model
  /// must outlive it. Where the model's file gives sizes of its own these stay.
  explicit Simulation(const mjModel& model, double most_memory = kMostMemory);

  const mjModel& model() const { return model_; }
  mjData* data() const { return data_.get(); }
  /// It has more contacts than there may be memory for.
  bool is_full() const { return full_; }
  Room room() const { return {model_.nconmax, model_.njmax, model_.nstack}; }

  /// mj_step1() and mj_step2(): what the state means, and a step of it. False where MuJoCo gave up.
  /// Allocate only to grow.
  bool evaluate() noexcept;
  bool advance() noexcept;

 private:
  bool grow(bool out_of_stack) noexcept;
  bool is_crowded() const noexcept;

  mjModel model_;  // shallow: all but the sizes is the given one's
  Data data_;
  double most_memory_;  // [bytes]
  bool fixed_;          // the file says how much
  bool full_ = false;
};

}  // namespace feltwire::mujoco
