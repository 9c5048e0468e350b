// The loader must survive a lack of memory.

#include <gtest/gtest.h>

#include <cstdio>
#include <thread>

#include "core/scene_file/load_scene.hpp"
#include "tests/support/failing_allocation.hpp"

namespace feltwire::load_scene_fault_test {
namespace {

#ifndef FELTWIRE_SANITIZED
/// Returns true if the scene loads in a separate thread. Refused memory must not affect the caller.
bool loads(const std::string& file) {
  bool loaded = false;
  std::thread([&] {
    try {
      load_scene(file);
      loaded = true;
    } catch (const std::exception&) {
      // A load without memory ends here.
    }
  }).join();
  return loaded;
}

/// Refuses every allocation of the loader in turn. Each load must end in an exception or continue
/// without the memory. The next load must work as the first.
TEST(LoadSceneFaults, OfEveryAllocationEndTheLoadOnly) {
  int injected = 0, ended = 0;
  for (const std::string name : {"plane.json", "room.json", "workshop.json"}) {
    const std::string file = FELTWIRE_SOURCE_DIR "/scenes/" + name;
    for (int n = 1;; ++n) {
      bool happened = false, loaded = false;
      {
        const test::FailingAllocation failing(n);
        loaded = loads(file);
        happened = failing.happened();
      }
      if (!happened) break;
      ++injected;
      ended += loaded ? 0 : 1;
    }
    EXPECT_TRUE(loads(file)) << file;
  }
  std::printf("%d allocations refused in turn, %d loads ended by it\n", injected, ended);
  RecordProperty("injected", injected);
  EXPECT_GT(ended, 1000);
}
#endif

}  // namespace
}  // namespace feltwire::load_scene_fault_test
