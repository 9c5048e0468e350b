#pragma once
// Faults that a test asks a stand-in for, so many times.

#include <atomic>

namespace stand_in {

/// Whether there is one left of them, which is used up.
inline bool takes_one(std::atomic<int>& count) {
  if (count.load() <= 0) return false;
  --count;
  return true;
}

}  // namespace stand_in
