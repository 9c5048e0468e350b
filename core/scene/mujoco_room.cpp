#include "core/scene/mujoco_room.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/scene/mujoco_sort.hpp"

namespace feltwire::mujoco {
namespace {

constexpr int kFewContacts = 16, kContactsOfGeom = 4;
// What MuJoCo 2.2 takes where the file has no <size>.
constexpr int kDefaultContacts = 100, kDefaultRows = 500;
constexpr int kMostFriction = 6;                // dimensions of a contact
constexpr int kRowsOfEquality = 6;              // a weld's
constexpr double kFirstStack = 1 << 20;         // numbers
constexpr double kMostStack = 2.0 * (1 << 27);  // numbers, 2 GiB; what is not used takes no memory
constexpr double kNumber = sizeof(mjtNum), kIndex = sizeof(int);

/// Of one contact, of the most friction that there is in the model.
int rows_of_contact(const mjModel& model) {
  int dimensions = 1;
  for (int g = 0; g < model.ngeom; ++g) dimensions = std::max(dimensions, model.geom_condim[g]);
  for (int p = 0; p < model.npair; ++p) dimensions = std::max(dimensions, model.pair_dim[p]);
  dimensions = std::min(dimensions, kMostFriction);
  const bool pyramid = model.opt.cone == mjCONE_PYRAMIDAL && dimensions > 1;
  return pyramid ? 2 * (dimensions - 1) : dimensions;
}

/// Of all that is no contact, at most.
int other_rows(const mjModel& model) {
  int rows = kRowsOfEquality * model.neq;
  for (int i = 0; i < model.nv; ++i) rows += model.dof_frictionloss[i] > 0.0 ? 1 : 0;
  for (int j = 0; j < model.njnt; ++j) rows += model.jnt_limited[j] != 0 ? 2 : 0;
  for (int t = 0; t < model.ntendon; ++t)
    rows += (model.tendon_limited[t] != 0 ? 2 : 0) + (model.tendon_frictionloss[t] > 0.0 ? 1 : 0);
  return rows;
}

/// Numbers that kinematics and the search for contacts take at once, as measured with some to
/// spare.
double least_stack(const mjModel& model, int rows) {
  constexpr double kVectors = 64.0;
  const double bodies = model.nbody;
  return bodies * bodies + kVectors * (1.0 + bodies + model.nv + model.ngeom + model.njnt + rows);
}

/// The same with the solvers: Newton's matrices of all speeds, the second one's of all rows.
double whole_stack(const mjModel& model, int rows) {
  constexpr double kNewton = 3.0, kSecond = 2.0;
  const double nv = model.nv, all = rows;
  const double newton = model.opt.solver == mjSOL_NEWTON ? kNewton * nv * nv : 0.0;
  return least_stack(model, rows) + std::max(newton, kSecond * all * all);
}

int numbers(double count) { return static_cast<int>(std::min(count, kMostStack)); }

/// The file has sizes of its own: something else than what MuJoCo makes of none.
bool has_own_room(const mjModel& m) {
  constexpr double kOfSquare = 5.0, kOfOthers = 20.0, kLeast = 1000.0;
  const double square = m.njmax + m.neq + m.nv;
  const double others = m.nq + m.nv + m.nu + m.na + m.nbody + m.njnt + m.ngeom + m.nsite + m.neq +
                        m.ntendon + m.nwrap;
  const double stack = std::max(kLeast, kOfSquare * square * square + kOfOthers * others);
  return m.nconmax != kDefaultContacts || m.njmax != kDefaultRows ||
         static_cast<double>(m.nstack) != stack;
}

void give(mjModel& model, const Room& room) {
  model.nconmax = room.contacts;
  model.njmax = room.rows;
  model.nstack = room.stack;
}

}  // namespace

double bytes(const mjModel& model, const Room& room) {
  // The constraints' Jacobian and its transpose with their columns, the matrix between all rows.
  const double entry = kNumber + kIndex, rows = room.rows;
  return 2.0 * entry * rows * model.nv + entry * rows * rows +
         static_cast<double>(sizeof(mjContact)) * room.contacts;
}

void leave_room_open(mjModel& model) {
  if (!has_own_room(model)) model.nconmax = 0;
}

Room first_room(const mjModel& model) {
  int moving = 0;
  for (int g = 0; g < model.ngeom; ++g)
    moving += model.body_weldid[model.geom_bodyid[g]] != 0 ? 1 : 0;
  const int others = other_rows(model), each = rows_of_contact(model);
  Room room;
  room.contacts = 2 * (kFewContacts + kContactsOfGeom * moving);
  do {
    room.contacts = std::max(kFewContacts, room.contacts / 2);
    room.rows = others + each * room.contacts;
  } while (bytes(model, room) > kFirstMemory && room.contacts > kFewContacts);
  const double least = std::max(least_stack(model, room.rows), kFirstStack);
  room.stack = numbers(std::min(whole_stack(model, room.rows), least));
  return room;
}

Simulation::Simulation(const mjModel& model, double most_memory)
    : model_(model), most_memory_(most_memory), fixed_(model.nconmax > 0) {
  bring_own_sort();
  if (!fixed_) give(model_, first_room(model));
  data_ = make_data(model_);
  if (data_ == nullptr && !fixed_) {  // the stack that it may take later on, all at once
    model_.nstack = numbers(whole_stack(model_, model_.njmax));
    data_ = make_data(model_);
  }
  if (data_ == nullptr || !evaluate())
    throw std::runtime_error("MuJoCo cannot evaluate the bodies where they start");
}

bool Simulation::is_crowded() const noexcept {
  return data_->warning[mjWARN_CONTACTFULL].number != 0 ||
         data_->warning[mjWARN_CNSTRFULL].number != 0;
}

bool Simulation::evaluate() noexcept {
  for (;;) {
    const bool done = guarded([&] { mj_step1(&model_, data_.get()); });
    if (done && !is_crowded()) return true;
    if (done ? !grow(false) : !(ran_out_of_stack() && grow(true))) return done;
  }
}

bool Simulation::advance() noexcept {
  while (!guarded([&] { mj_step2(&model_, data_.get()); }))
    if (!ran_out_of_stack() || !grow(true) || !evaluate()) return false;
  return true;
}

/// Twice as much of what ran out, and the state as it was before; false where that may not be.
bool Simulation::grow(bool out_of_stack) noexcept {
  if (fixed_ || (full_ && !out_of_stack)) return false;
  mjModel larger = model_;
  if (out_of_stack) {
    const double whole = whole_stack(model_, model_.njmax), have = model_.nstack;
    larger.nstack = numbers(have < whole ? whole : 2.0 * have);
    if (larger.nstack == model_.nstack) return false;
  } else {
    if (data_->warning[mjWARN_CONTACTFULL].number != 0) larger.nconmax *= 2;
    const int needed = other_rows(model_) + rows_of_contact(model_) * larger.nconmax;
    larger.njmax = data_->warning[mjWARN_CNSTRFULL].number != 0 ? 2 * model_.njmax
                                                                : std::max(model_.njmax, needed);
    full_ = bytes(larger, {larger.nconmax, larger.njmax, larger.nstack}) > most_memory_;
    if (full_) return false;
  }
  mjData* made = nullptr;
  const bool ran = guarded([&] { made = mj_makeData(&larger); });
  if (!ran || made == nullptr) {
    full_ = full_ || !out_of_stack;
    return false;
  }
  std::copy_n(data_->qpos, model_.nq, made->qpos);
  std::copy_n(data_->qvel, model_.nv, made->qvel);
  std::copy_n(data_->act, model_.na, made->act);
  std::copy_n(data_->qacc_warmstart, model_.nv, made->qacc_warmstart);
  std::copy_n(data_->qfrc_applied, model_.nv, made->qfrc_applied);
  made->time = data_->time;
  data_.reset(made);
  model_ = larger;
  return true;
}

}  // namespace feltwire::mujoco
