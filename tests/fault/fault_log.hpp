#pragma once
// The log of the library that injects faults about a process, in a file that both it and the driver
// have mapped. tests/fault/run.py reads it by these offsets.

#include <atomic>
#include <cstdint>

namespace feltwire::fault {

/// One place in the program from which one call is made, known by the calls that led there.
struct Place {
  std::atomic<std::uint64_t> hash{0};  // 0: free
  std::atomic<std::uint64_t> count{0};
  std::uint64_t call = 0;  // index of kCalls
};

struct Log {
  static constexpr std::uint64_t kPlaces = 1 << 15;

  std::atomic<std::uint64_t> injected{0};     // 0: the point was not reached
  std::atomic<std::int64_t> injected_at{0};   // [ns]
  std::atomic<std::uint64_t> told{0};         // times that the device was told anything
  std::atomic<double> force{0.0};             // [N] what it was told last
  std::atomic<double> largest{0.0};           // [N]
  std::atomic<std::int64_t> told_at{0};       // [ns]
  std::atomic<std::int64_t> longest_hold{0};  // [ns] that a force was held without a word
  std::atomic<std::uint64_t> overflow{0};     // places that found no room
  Place places[kPlaces];
};

}  // namespace feltwire::fault
