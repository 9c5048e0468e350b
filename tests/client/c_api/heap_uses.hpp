#pragma once
// Functions of the C interface that may be called from a real-time thread do not use the heap.

#include <gmock/gmock.h>

#include <cstddef>
#include <cstdint>

#include "client/c_api/feltwire.h"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::test {

/// Calls a function of the C interface 500 times. Returns how often it allocated or freed memory.
/// None of its results may be an error.
template <class Call>
std::size_t uses_of_heap(Call call) {
  constexpr int kCalls = 500;
  int errors = 0;
  const std::size_t before = allocations();
  for (int i = 0; i < kCalls; ++i) errors += call() < FW_OK ? 1 : 0;
  const std::size_t uses = allocations() - before;
  EXPECT_EQ(errors, 0) << fw_last_error();
  return uses;
}

}  // namespace feltwire::test
