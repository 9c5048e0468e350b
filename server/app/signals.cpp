#include "server/app/signals.hpp"

#include <spdlog/spdlog.h>

#include <cstring>
#include <exception>

namespace feltwire {
namespace {

/// Null: the signal ends the wait.
const std::function<void()>* handler_of(const SignalHandlers& handlers, int signal) {
  switch (signal) {
    case SIGUSR1:
      return &handlers.count;
    case SIGHUP:
      return &handlers.reload;
    case SIGCHLD:
      return &handlers.child;
    default:
      return nullptr;
  }
}

}  // namespace

sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGHUP, SIGCHLD}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int wait_for_end(const sigset_t& signals, const SignalHandlers& handlers) {
  for (int signal = 0; sigwait(&signals, &signal) == 0;) {
    const auto* const handler = handler_of(handlers, signal);
    if (handler == nullptr) return signal;
    try {
      (*handler)();
    } catch (const std::exception& error) {
      spdlog::error("signal {}: {}; the server goes on", ::sigabbrev_np(signal), error.what());
    }
  }
  return 0;  // sigwait() has failed: the set is not valid
}

}  // namespace feltwire
