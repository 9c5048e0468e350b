#pragma once
// A test's settings for a stand-in in another program, and its results: a memory page that both map
// from a file. It knows nothing of feltwire.

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>

#include "tests/devices/simulated_mass.hpp"

namespace stand_in {

/// The environment variable with the file's name.
inline constexpr const char* kPageVariable = "FELTWIRE_STAND_IN_PAGE";

struct Page {
  // The test sets these, the first three before the program starts.
  std::atomic<double> waits{0.0};     // [s] for which the hand is still at the start
  std::atomic<bool> by_clock{false};  // the mass moves by the clock, even without ticks
  std::atomic<int> devices{1};        // on USB
  std::atomic<unsigned> buttons{0};
  std::atomic<bool> unplugged{false}, refuses{false};  // no more readings; no forces
  std::atomic<int> slow_read{0};                       // [ms] duration of a reading
  std::atomic<int> stall{0};                           // [ms] duration of the next reading only

  // The stand-in sets these.
  std::atomic<int> number{-1};                        // of the open device
  std::atomic<long> ticks{0};                         // of the device
  std::atomic<double> force{0.0};                     // [N] on the mass
  std::atomic<double> largest_force{0.0}, made{0.0};  // [N], [J] of the mass's true motion

  /// Called at each tick of the stand-in.
  void tell(const SimulatedMass& mass) noexcept {
    tell_motion(mass);
    ticks.fetch_add(1);
  }
  void tell_motion(const SimulatedMass& mass) noexcept {
    largest_force.store(mass.largest_force);
    made.store(mass.most_made);
  }
  static_assert(std::atomic<double>::is_always_lock_free && std::atomic<long>::is_always_lock_free);
};

/// Maps the file. Throws std::runtime_error.
inline void* mapped_page(const std::string& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  void* const room =
      descriptor >= 0 && ::ftruncate(descriptor, sizeof(Page)) == 0
          ? ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0)
          : MAP_FAILED;
  if (descriptor >= 0) ::close(descriptor);
  if (room == MAP_FAILED) throw std::runtime_error("no page: " + file);
  return room;
}

/// For the stand-in: the page of the test that started this program, or null.
inline Page* page() {
  static Page* const mapped = [] {
    const char* const file = std::getenv(kPageVariable);
    return file != nullptr ? static_cast<Page*>(mapped_page(file)) : nullptr;
  }();
  return mapped;
}

/// For the stand-in at its opening: puts the hand at the height of its taps.
inline void begin_for_page(SimulatedMass& mass, int number) {
  if (page() == nullptr) return;
  mass.position = {0.0, 0.0, 0.004};
  mass.waits = page()->waits.load();
  page()->number.store(number);
}

/// For the test: a new page for the programs that it starts during its life.
class NewPage {
 public:
  explicit NewPage(const std::string& file) : page_(new (mapped_page(file)) Page) {
    ::setenv(kPageVariable, file.c_str(), 1);
  }
  ~NewPage() {
    ::unsetenv(kPageVariable);
    ::munmap(page_, sizeof(Page));
  }
  NewPage(const NewPage&) = delete;
  NewPage& operator=(const NewPage&) = delete;
  Page* operator->() const { return page_; }

 private:
  Page* page_;
};

}  // namespace stand_in
