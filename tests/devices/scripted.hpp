#pragma once
// Counts of faults that a test requests from a stand-in.

#include <atomic>

namespace stand_in {

/// True if a fault is left; uses it up.
inline bool takes_one(std::atomic<int>& count) {
  if (count.load() <= 0) return false;
  --count;
  return true;
}

}  // namespace stand_in
