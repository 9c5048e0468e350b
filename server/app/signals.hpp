#pragma once
// The signals of the program.

#include <csignal>
#include <functional>

namespace feltwire {

struct SignalHandlers {
  std::function<void()> count;          // SIGUSR1
  std::function<void()> reload;         // SIGHUP
  std::function<void()> child = [] {};  // SIGCHLD: a program that this one started has ended
};

/// SIGINT, SIGTERM, SIGUSR1, SIGHUP and SIGCHLD. They are blocked in the calling thread and in all
/// threads that it starts afterwards.
sigset_t block_signals();

/// Waits in the calling thread until one of `signals` without a handler here comes, and returns it.
/// The signals are blocked in every thread. An exception of a handler is logged, and the wait
/// continues.
int wait_for_end(const sigset_t& signals, const SignalHandlers& handlers);

}  // namespace feltwire
