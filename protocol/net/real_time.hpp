#pragma once
// A thread that must not wait for others.

#include <string>

namespace feltwire {

/// The real-time rights that the system granted to the calling thread. Without them it runs with
/// more jitter.
struct RealTime {
  bool scheduler = false;      // SCHED_FIFO
  bool memory_locked = false;  // what is mapped now stays in memory
};

/// Priorities of SCHED_FIFO: above other programs, below the kernel's own interrupt threads (docs
/// of PREEMPT_RT). On one machine the hand comes before the scenes.
inline constexpr int kServoPriority = 80, kScenePriority = 70;

/// `priority` 0: not SCHED_FIFO, under which the kernel takes 50 ms of every second from a thread
/// that never sleeps. Timers are as exact as there are, in any case.
RealTime request_real_time(int priority) noexcept;

/// The calling thread, and each that it starts from now on, comes after the others (nice 10): for
/// what may be late. It cannot be taken back.
void give_way() noexcept;

/// What was asked for by that priority and is not permitted, with the remedy; empty when all is
/// granted.
std::string missing(RealTime granted, int priority);

}  // namespace feltwire
