#include "core/scene/mujoco_guard.hpp"

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdlib>
#include <cstring>
#include <mutex>

namespace feltwire::mujoco {
namespace {

thread_local std::jmp_buf* way_out = nullptr;
thread_local bool stack_overflowed = false;

// MuJoCo is C: an exception may not pass through it, and a handler that returns ends the process.
void on_error(const char* message) {
  stack_overflowed = std::strstr(message, "tack overflow") != nullptr;
  if (way_out != nullptr) std::longjmp(*way_out, 1);
}
// Every warning of a simulation is counted in its mjData, too.
void on_warning(const char*) {}

void install_handlers() {
  static const bool installed = [] {
    mju_user_error = on_error;
    mju_user_warning = on_warning;
    return true;
  }();
  static_cast<void>(installed);
}

constexpr int kErrorSize = 1000;

/// The loader keeps what it read in a global.
Loaded load(const char* name, const mjVFS* files) {
  static std::mutex loading;
  const std::lock_guard lock(loading);
  install_handlers();
  std::array<char, kErrorSize> error{};
  mjModel* model = nullptr;
  const bool ran = guarded([&] { model = mj_loadXML(name, files, error.data(), kErrorSize); });
  Loaded loaded{Model(model), {}};
  if (model != nullptr) return loaded;
  loaded.error = ran && error[0] != '\0' ? error.data() : "MuJoCo gave up on it";
  while (!loaded.error.empty() && loaded.error.back() == '\n') loaded.error.pop_back();
  for (char& c : loaded.error)
    if (c == '\n') c = ' ';
  return loaded;
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

Loaded load_text(const std::string& xml) {
  struct DeleteFiles {
    void operator()(mjVFS* files) const noexcept {
      mj_deleteVFS(files);
      delete files;
    }
  };
  const std::unique_ptr<mjVFS, DeleteFiles> files(new mjVFS);
  mj_defaultVFS(files.get());
  constexpr const char* kName = "scene.xml";
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()));
  std::copy(xml.begin(), xml.end(),
            static_cast<char*>(files->filedata[mj_findFileVFS(files.get(), kName)]));
  return load(kName, files.get());
}

Loaded load_file(const std::string& file) { return load(file.c_str(), nullptr); }

Data make_data(const mjModel& model) {
  install_handlers();
  mjData* data = nullptr;
  const bool ran = guarded([&] {
    data = mj_makeData(&model);
    mj_forward(&model, data);
  });
  Data owned(data);
  return ran ? std::move(owned) : nullptr;
}

}  // namespace feltwire::mujoco
