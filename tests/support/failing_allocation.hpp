#pragma once
// Allocations that fail. Replaces the global operator new; under sanitizers it does nothing: skip
// such tests there.

#include <cstdint>

namespace feltwire::test {

/// While this object lives, allocation `number` (from 1) by operator new throws std::bad_alloc,
/// once. It counts all threads except its own. Only one such object may live at a time.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::int64_t number);
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;
  bool happened() const;
};

}  // namespace feltwire::test
