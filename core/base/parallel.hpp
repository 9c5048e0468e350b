#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/cancellation.hpp"

namespace feltwire {

/// Whether the calling thread runs a call of parallel_for().
inline thread_local bool inside_parallel_for = false;

/// Calls work(i) for every i < count, on as many threads as the machine has cores. If the system
/// refuses threads, it uses fewer, at least the calling one. The calls must not depend on each
/// other; results that they write by index then do not depend on the number of threads. Rethrows
/// the first exception after all threads have ended. Calls check_cancelled() before each call. Is a
/// step of the work of the calling thread (cancellation.hpp), unless it runs inside of another
/// parallel_for().
template <class Work>
void parallel_for(std::size_t count, const Work& work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failing;
  CancellableWork* const whole = current_work();
  // Calls inside of another parallel_for() are parts of its step.
  CancellableWork* const told = inside_parallel_for ? nullptr : whole;
  if (told != nullptr) told->begin_step(count);
  const auto worker = [&] {
    const WorkScope part(whole);
    const bool before = std::exchange(inside_parallel_for, true);
    try {
      for (std::size_t i = next++; i < count; i = next++) {
        check_cancelled();
        if (told != nullptr) told->advance(i);
        work(i);
      }
    } catch (...) {
      const std::lock_guard lock(failing);
      if (!failure) failure = std::current_exception();
      next = count;
    }
    inside_parallel_for = before;
  };
  {
    const std::size_t wanted =
        std::min<std::size_t>(count, std::max(1u, std::thread::hardware_concurrency()));
    std::vector<std::jthread> threads;
    threads.reserve(wanted);
    try {
      while (threads.size() < wanted) threads.emplace_back(worker);
    } catch (const std::system_error&) {
      // No memory for the stack of one more, or too many threads.
    }
    if (threads.empty()) worker();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace feltwire
