#include "core/dynamics/mujoco_buffers.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/base/written_number.hpp"
#include "core/dynamics/mujoco_sort.hpp"
#include "core/dynamics/mujoco_text.hpp"

namespace feltwire::mujoco {
namespace {

constexpr int kFewContacts = 16, kContactsOfGeom = 4;
// MuJoCo 2.2 uses these sizes if the file has no <size>.
constexpr int kDefaultContacts = 100, kDefaultRows = 500;
constexpr int kMostFriction = 6;         // largest friction dimension of a contact
constexpr int kRowsOfEquality = 6;       // rows of a weld constraint
constexpr double kFirstStack = 1 << 20;  // first size of the stack, as a count of mjtNum
// Largest size of the stack, as a count of mjtNum. These are 2 GiB. Unused stack takes no memory.
constexpr double kMostStack = 2.0 * (1 << 27);
constexpr double kNumber = sizeof(mjtNum), kIndex = sizeof(int);

/// Returns the number of constraint rows of a contact that has the largest friction dimension in
/// the model.
int rows_of_contact(const mjModel& model) {
  int dimensions = 1;
  for (int g = 0; g < model.ngeom; ++g) dimensions = std::max(dimensions, model.geom_condim[g]);
  for (int p = 0; p < model.npair; ++p) dimensions = std::max(dimensions, model.pair_dim[p]);
  dimensions = std::min(dimensions, kMostFriction);
  const bool pyramid = model.opt.cone == mjCONE_PYRAMIDAL && dimensions > 1;
  return pyramid ? 2 * (dimensions - 1) : dimensions;
}

/// Returns an upper bound of the number of constraint rows that belong to no contact.
int other_rows(const mjModel& model) {
  int rows = kRowsOfEquality * model.neq;
  for (int i = 0; i < model.nv; ++i) rows += model.dof_frictionloss[i] > 0.0 ? 1 : 0;
  for (int j = 0; j < model.njnt; ++j) rows += model.jnt_limited[j] != 0 ? 2 : 0;
  for (int t = 0; t < model.ntendon; ++t)
    rows += (model.tendon_limited[t] != 0 ? 2 : 0) + (model.tendon_frictionloss[t] > 0.0 ? 1 : 0);
  return rows;
}

/// Returns the stack size, as a count of mjtNum, for kinematics and collision detection. The
/// constants are measured values with a margin.
double least_stack(const mjModel& model, int rows) {
  constexpr double kVectors = 64.0;
  const double bodies = model.nbody;
  return bodies * bodies + kVectors * (1.0 + bodies + model.nv + model.ngeom + model.njnt + rows);
}

/// Returns least_stack() plus the stack size that the solvers need: Newton's matrices have one row
/// per degree of freedom, and the noslip solver's matrix has one row per constraint row.
double whole_stack(const mjModel& model, int rows) {
  constexpr double kNewton = 3.0, kSecond = 2.0;
  const double nv = model.nv, all = rows;
  const double newton = model.opt.solver == mjSOL_NEWTON ? kNewton * nv * nv : 0.0;
  return least_stack(model, rows) + std::max(newton, kSecond * all * all);
}

int numbers(double count) { return static_cast<int>(std::min(count, kMostStack)); }

/// Returns true if the buffer sizes differ from MuJoCo's default sizes. The file then sets its own
/// sizes.
bool has_own_room(const mjModel& m) {
  constexpr double kOfSquare = 5.0, kOfOthers = 20.0, kLeast = 1000.0;
  const double square = m.njmax + m.neq + m.nv;
  const double others = m.nq + m.nv + m.nu + m.na + m.nbody + m.njnt + m.ngeom + m.nsite + m.neq +
                        m.ntendon + m.nwrap;
  const double stack = std::max(kLeast, kOfSquare * square * square + kOfOthers * others);
  return m.nconmax != kDefaultContacts || m.njmax != kDefaultRows ||
         static_cast<double>(m.nstack) != stack;
}

void give(mjModel& model, const BufferSizes& room) {
  model.nconmax = room.contacts;
  model.njmax = room.rows;
  model.nstack = room.stack;
}

std::string in_gigabytes(double bytes) { return printed("%.3g GB", bytes / 1e9); }

}  // namespace

double bytes(const mjModel& model, const BufferSizes& room) {
  // Count the constraint Jacobian and its transpose, both with column indices. Add the square
  // matrix of all rows.
  const double entry = kNumber + kIndex, rows = room.rows;
  return 2.0 * entry * rows * model.nv + entry * rows * rows +
         static_cast<double>(sizeof(mjContact)) * room.contacts;
}

void leave_room_open(mjModel& model) {
  if (!has_own_room(model)) model.nconmax = 0;
}

BufferSizes first_room(const mjModel& model) {
  int moving = 0;
  for (int g = 0; g < model.ngeom; ++g)
    moving += model.body_weldid[model.geom_bodyid[g]] != 0 ? 1 : 0;
  const int others = other_rows(model), each = rows_of_contact(model);
  BufferSizes room;
  room.contacts = 2 * (kFewContacts + kContactsOfGeom * moving);
  do {
    room.contacts = std::max(kFewContacts, room.contacts / 2);
    room.rows = others + each * room.contacts;
  } while (bytes(model, room) > kFirstMemory && room.contacts > kFewContacts);
  const double least = std::max(least_stack(model, room.rows), kFirstStack);
  room.stack = numbers(std::min(whole_stack(model, room.rows), least));
  return room;
}

bool has_range(const Body& body) {
  const Body none;
  return body.low != none.low || body.high != none.high;
}

std::string trial_room(std::size_t objects, const std::vector<Body>& bodies) {
  constexpr std::size_t kContacts = 16, kRows = 3, kVectors = 64, kNewton = 3;
  std::size_t rows = kRows * kContacts, speeds = 0, held = 0;
  for (const Body& body : bodies) {
    const bool is_free = body.joint == Joint::free;
    speeds += is_free ? 6 : 1;
    const std::size_t own = is_free ? 0 : (has_range(body) ? 2 : 0) + (body.friction > 0.0 ? 1 : 0);
    rows += own;
    held += own > 0 ? 1 : 0;
  }
  const std::size_t count = bodies.size();
  const std::size_t solver = count <= kFewBodies ? kNewton * speeds * speeds : 0;
  const std::size_t stack = solver + 2 * rows * rows + count * count +
                            kVectors * (1 + rows + speeds + 2 * count + 7 * objects);
  // mj_makeData() allocates two blocks: one for the constraints and one for the stack. It counts
  // the bytes of each block in an int, so kMost [bytes] limits each block. kEntry [bytes] is the
  // size of a matrix entry with its column index.
  constexpr double kMost = 2e9, kEntry = sizeof(mjtNum) + sizeof(int);
  const auto r = static_cast<double>(rows), v = static_cast<double>(speeds);
  const double most =
      std::max(kEntry * (2.0 * r * v + r * r), sizeof(mjtNum) * static_cast<double>(stack));
  if (most > kMost)
    throw std::invalid_argument("bodies: the " + std::to_string(count) + " bodies, " +
                                std::to_string(held) + " of them with a range or friction, take " +
                                in_gigabytes(most) + " at once in MuJoCo, which takes at most " +
                                in_gigabytes(kMost) +
                                "; have fewer bodies, or fewer with a range or friction");
  return "<size" + attribute("nconmax", std::to_string(kContacts)) +
         attribute("njmax", std::to_string(rows)) + attribute("nstack", std::to_string(stack)) +
         "/>\n";
}

Simulation::Simulation(const mjModel& model, double most_memory, const std::vector<mjtNum>& start)
    : model_(model), most_memory_(most_memory), fixed_(model.nconmax > 0) {
  bring_own_sort();
  if (!fixed_) give(model_, first_room(model));
  data_ = make_data(model_, start);
  // If the first stack is too small, allocate the largest stack that the model needs.
  if (data_ == nullptr && !fixed_) {
    model_.nstack = numbers(whole_stack(model_, model_.njmax));
    data_ = make_data(model_, start);
  }
  if (data_ == nullptr || !evaluate())
    throw std::runtime_error("MuJoCo cannot evaluate the bodies where they start");
}

Vec3 Simulation::gravity() const { return vector(model_.opt.gravity); }

void Simulation::set_gravity(const Vec3& gravity) noexcept {
  std::copy_n(gravity.data(), 3, model_.opt.gravity);
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

/// Enlarges the buffer that is full and copies the state. Returns false if the buffer must not
/// grow.
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
  std::copy_n(data_->ctrl, model_.nu, made->ctrl);
  std::copy_n(data_->qacc_warmstart, model_.nv, made->qacc_warmstart);
  std::copy_n(data_->qfrc_applied, model_.nv, made->qfrc_applied);
  made->time = data_->time;
  data_.reset(made);
  model_ = larger;
  return true;
}

}  // namespace feltwire::mujoco
