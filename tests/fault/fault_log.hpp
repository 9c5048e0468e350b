#pragma once
// The log of the fault injection library about a process, in a file that the library and its driver
// map. tests/fault/run.py reads it by these offsets.

#include <atomic>
#include <cstdint>

namespace feltwire::fault {

/// A place of the program that makes a call, identified by its stack.
struct Place {
  std::atomic<std::uint64_t> hash{0};  // 0: free
  std::atomic<std::uint64_t> count{0};
  std::uint64_t call = 0;  // index of kCalls
};

struct Log {
  static constexpr std::uint64_t kPlaces = 1 << 15;

  std::atomic<std::uint64_t> injected{0};     // 0: the fault's place was not reached
  std::atomic<std::int64_t> injected_at{0};   // [ns]
  std::atomic<std::uint64_t> told{0};         // number of device commands
  std::atomic<double> force{0.0};             // [N] of the last command
  std::atomic<double> largest{0.0};           // [N]
  std::atomic<std::int64_t> told_at{0};       // [ns]
  std::atomic<std::int64_t> longest_hold{0};  // [ns] longest hold of a force without a new command
  std::atomic<std::uint64_t> overflow{0};     // places without room
  Place places[kPlaces];
};

}  // namespace feltwire::fault
