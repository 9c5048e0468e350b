#pragma once
// Allocations that fail. Replaces the global operator new, which does nothing under sanitizers:
// skip such tests there.

#include <cstdint>

namespace feltwire::test {

/// While this lives, allocation `number` (from 1) by operator new of all threads but the one that
/// made it throws std::bad_alloc, once. One at a time.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::int64_t number);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  bool happened() const;
};

}  // namespace feltwire::test
