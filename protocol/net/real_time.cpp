#include "protocol/net/real_time.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace feltwire {

RealTime request_real_time(int priority) noexcept {
  RealTime granted;
  const sched_param parameters{.sched_priority = priority};
  granted.scheduler =
      priority > 0 && pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
  // Do not use MCL_FUTURE: under a memory limit, later allocations of other threads would fail.
  granted.memory_locked = mlockall(MCL_CURRENT) == 0;
  prctl(PR_SET_TIMERSLACK, 1UL);  // 1 ns; the default is 50 us
  return granted;
}

void give_way() noexcept {
  constexpr int kNice = 10;
  // On Linux, each thread has its own nice value, and setpriority() accepts a thread number.
  ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kNice);
}

std::string missing(RealTime granted, int priority) {
  const bool scheduler = granted.scheduler || priority == 0;
  if (scheduler && granted.memory_locked) return {};
  return std::string(scheduler               ? "locking memory is"
                     : granted.memory_locked ? "real-time scheduling is"
                                             : "real-time scheduling and locking memory are") +
         " not permitted; allow it with CAP_SYS_NICE and CAP_IPC_LOCK or in limits.conf (rtprio, "
         "memlock)";
}

}  // namespace feltwire
