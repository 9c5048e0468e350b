#pragma once
// Internal to core/dynamics: safe calls of MuJoCo. Without these, an error in MuJoCo ends the
// process, and a warning writes a file.

#include <mujoco/mujoco.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

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

/// The entry `index` of an array whose entries have kNumbers numbers each.
template <int kNumbers>
const mjtNum* entry(const mjtNum* all, int index) {
  return all + std::ptrdiff_t{kNumbers} * index;
}

inline Vec3 vector(const mjtNum* v) { return {v[0], v[1], v[2]}; }
inline Quaternion quaternion(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }

/// A model, or MuJoCo's error message.
struct Loaded {
  Model model;
  std::string error;
  std::vector<std::string> files = {};  // the files that were read, with MuJoCo's names
};
/// Load a model in a child process (mjcf_reader.cpp), so that a fault of MuJoCo's loader on a bad
/// file does not reach this process.
Loaded load_text(const std::string& xml);
/// Reads only files below `root`, an absolute path without links; empty: any file. `text`, where it
/// is not null, stands for the file's own; files that it names still lie beside the file.
Loaded load_file(const std::string& file, const std::string& root = {},
                 const std::string* text = nullptr);

/// Reads a file that mj_saveModel() wrote; null for any other file.
Model read_binary(const std::string& file);

/// A state of the model, evaluated. Null if MuJoCo refuses. `start`: its coordinates (qpos); empty:
/// those of the model.
Data make_data(const mjModel& model, const std::vector<mjtNum>& start = {});

/// Calls call(argument). Returns false if MuJoCo failed with an error. An error leaves the call by
/// longjmp. So the call may use only MuJoCo's engine, which is C, and must own nothing that needs a
/// destructor. Do not use it for MuJoCo's loader, which is C++.
bool guarded(void (*call)(void*), void* argument) noexcept;
/// Whether this thread's last call failed because MuJoCo's stack is too small.
bool ran_out_of_stack() noexcept;
template <class Call>
bool guarded(Call call) noexcept {
  return guarded([](void* own) { (*static_cast<Call*>(own))(); }, &call);
}

}  // namespace feltwire::mujoco
