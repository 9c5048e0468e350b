#include "client/c_api/end_at_exit.hpp"

#include <unistd.h>

#include <cstdlib>
#include <mutex>
#include <vector>

namespace feltwire {
namespace {

struct LeftOpen {
  void* object = nullptr;
  void (*end)(void* object) noexcept = nullptr;
  pid_t process = 0;  // a child process has none of the threads
};

/// Never freed, because a thread of the program may close a handle after the last exit handler.
struct AllLeftOpen {
  std::mutex mutex;
  std::vector<LeftOpen> objects;
};

AllLeftOpen& all_left_open() {
  static auto& all = *new AllLeftOpen;
  return all;
}

void end_all() noexcept {
  AllLeftOpen& all = all_left_open();
  const std::lock_guard lock(all.mutex);
  for (; !all.objects.empty(); all.objects.pop_back())
    if (const LeftOpen& last = all.objects.back(); last.process == ::getpid())
      last.end(last.object);
}

}  // namespace

void end_at_exit(void* object, void (*end)(void* object) noexcept) {
  AllLeftOpen& all = all_left_open();
  const std::lock_guard lock(all.mutex);
  static const bool registered = std::atexit(end_all) == 0;
  static_cast<void>(registered);
  all.objects.push_back({object, end, ::getpid()});
}

void closes(const void* object) noexcept {
  AllLeftOpen& all = all_left_open();
  const std::lock_guard lock(all.mutex);
  std::erase_if(all.objects, [&](const LeftOpen& one) { return one.object == object; });
}

}  // namespace feltwire
