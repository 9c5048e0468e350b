#pragma once
// Real-time scheduling of a thread.

#include <string>

namespace feltwire {

/// The real-time rights that the system granted to the calling thread. Without them it runs with
/// more jitter.
struct RealTime {
  bool scheduler = false;      // SCHED_FIFO
  bool memory_locked = false;  // memory mapped now stays in memory
};

/// Priorities of SCHED_FIFO: above other programs, below the kernel's own interrupt threads (docs
/// of PREEMPT_RT). On one machine the hand comes before the scenes.
inline constexpr int kServoPriority = 80, kScenePriority = 70;

/// `priority` 0: not SCHED_FIFO, under which the kernel takes 50 ms of every second from a thread
/// that never sleeps. Timers are as exact as possible in every case.
RealTime request_real_time(int priority) noexcept;

/// Gives the calling thread, and all threads that it starts from now on, a lower priority than the
/// others (nice 10), for work that may be late. It cannot be undone.
void give_way() noexcept;

/// The rights that this priority needs and that were not granted, with the remedy; empty if all
/// were granted.
std::string missing(RealTime granted, int priority);

}  // namespace feltwire
