#pragma once
// Every path of a sample must give equal bits each time and must not allocate.

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.hpp"

namespace feltwire::test {

/// Runs twice and returns the result of the first run.
template <class Run>
auto same_twice_without_allocation(const Run& run) {
  const std::size_t before = allocations();
  const auto first = run();
#ifndef FELTWIRE_SANITIZED  // sanitizers allocate by themselves
  EXPECT_EQ(allocations(), before);
#else
  static_cast<void>(before);
#endif
  EXPECT_EQ(first, run());
  return first;
}

}  // namespace feltwire::test
