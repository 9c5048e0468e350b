#pragma once
// Internal to core/scene: MuJoCo, made safe to call. By itself it ends the process on an error and
// writes a file on a warning.

#include <mujoco/mujoco.h>

#include <cstddef>
#include <memory>
#include <string>

#include "core/base/types.hpp"

namespace feltwire::mujoco {

struct DeleteModel {
  void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
};
struct DeleteData {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};
using Model = std::unique_ptr<mjModel, DeleteModel>;
using Data = std::unique_ptr<mjData, DeleteData>;

/// The `index`-th of an array of so many numbers each.
template <int kNumbers>
const mjtNum* entry(const mjtNum* all, int index) {
  return all + std::ptrdiff_t{kNumbers} * index;
}

inline Vec3 vector(const mjtNum* v) { return {v[0], v[1], v[2]}; }
inline Quaternion quaternion(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }

/// A model, or why there is none, in MuJoCo's words.
struct Loaded {
  Model model;
  std::string error;
};
/// By a child process (mjcf_reader.cpp), so that nothing that MuJoCo's loader does with a bad file
/// reaches this one.
Loaded load_text(const std::string& xml);
Loaded load_file(const std::string& file);

/// Reads a file that mj_saveModel() wrote; null where it is no such file.
Model read_binary(const std::string& file);

/// A state of the model, evaluated; null where MuJoCo refuses.
Data make_data(const mjModel& model);

/// Calls; false where MuJoCo gave up with an error. What it calls must be MuJoCo's engine, which is
/// C, and hold nothing that a destructor would have to give back: an error leaves it by longjmp.
/// Not for MuJoCo's loader, which is C++.
bool guarded(void (*call)(void*), void* argument) noexcept;
/// Whether this thread's last call failed because MuJoCo's stack is too small.
bool ran_out_of_stack() noexcept;
template <class Call>
bool guarded(Call call) noexcept {
  return guarded([](void* own) { (*static_cast<Call*>(own))(); }, &call);
}

}  // namespace feltwire::mujoco
