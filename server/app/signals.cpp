#include "server/app/signals.hpp"

#include <spdlog/spdlog.h>

#include <exception>

namespace feltwire {

sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int wait_for_end(const sigset_t& signals, const SignalHandlers& handlers) {
  for (int signal = 0; sigwait(&signals, &signal) == 0;) {
    if (signal != SIGUSR1 && signal != SIGHUP) return signal;
    try {
      (signal == SIGUSR1 ? handlers.count : handlers.reload)();
    } catch (const std::exception& error) {
      spdlog::error("signal {}: {}; the server goes on", signal == SIGUSR1 ? "USR1" : "HUP",
                    error.what());
    }
  }
  return 0;  // sigwait() has failed: the set is not valid
}

}  // namespace feltwire
