#pragma once
// Measures the cost of a call on this machine.

#include <time.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace feltwire {

/// [s] of CPU that the calling thread has used.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// [s] of CPU that all threads of the program have used.
inline double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Median over laps of the CPU time that one call of work(i), i = 0 ... count - 1, takes [ns]. To
/// be called while no other thread of the program works: caches, memory and cores are shared.
/// `clock`: another than the calling thread's, for tests [s].
template <class Work, class Clock = double (*)()>
double cost_ns(std::size_t count, const Work& work, std::size_t laps = 41,
               const Clock& clock = cpu_seconds) {
  std::vector<double> times;
  for (std::size_t lap = 0; lap < laps; ++lap) {
    const double start = clock();
    for (std::size_t i = 0; i < count; ++i) work(i);
    times.push_back((clock() - start) / static_cast<double>(count) * 1e9);
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(laps / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

}  // namespace feltwire
