#include "core/dynamics/mujoco_error_trap.hpp"

#include <algorithm>
#include <csetjmp>
#include <cstdlib>
#include <cstring>

namespace feltwire::mujoco {
namespace {

thread_local std::jmp_buf* way_out = nullptr;
thread_local bool stack_overflowed = false;

// Leaves MuJoCo's function by longjmp(). MuJoCo is C code, and an exception must not pass through C
// code. If this handler returned, MuJoCo would end the process.
void on_error(const char* message) {
  stack_overflowed = std::strstr(message, "tack overflow") != nullptr;
  if (way_out != nullptr) std::longjmp(*way_out, 1);
}
// Ignores warnings, because each simulation also counts them in its mjData.
void on_warning(const char*) {}

void install_handlers() {
  static const bool installed = [] {
    mju_user_error = on_error;
    mju_user_warning = on_warning;
    return true;
  }();
  static_cast<void>(installed);
}

}  // namespace

bool guarded(void (*call)(void*), void* argument) noexcept {
  std::jmp_buf here;
  std::jmp_buf* const outer = way_out;
  if (setjmp(here) != 0) {
    way_out = outer;
    return false;
  }
  way_out = &here;
  call(argument);
  way_out = outer;
  return true;
}

bool ran_out_of_stack() noexcept { return stack_overflowed; }

Model read_binary(const std::string& file) {
  install_handlers();
  mjModel* model = nullptr;
  guarded([&] { model = mj_loadModel(file.c_str(), nullptr); });
  return Model(model);
}

Data make_data(const mjModel& model, const std::vector<mjtNum>& start) {
  install_handlers();
  mjData* data = nullptr;
  const bool ran = guarded([&] {
    data = mj_makeData(&model);
    std::copy(start.begin(), start.end(), data->qpos);
    mj_forward(&model, data);
  });
  Data owned(data);
  return ran ? std::move(owned) : nullptr;
}

}  // namespace feltwire::mujoco
