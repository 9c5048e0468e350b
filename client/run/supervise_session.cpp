#include "client/run/supervise_session.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <system_error>

#include "client/run/emergency_key.hpp"

namespace feltwire {
namespace {

constexpr int kHousekeeping = 50;  // [ms] between checks of the rings

constexpr std::array kEnding = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};

std::atomic<pthread_t> taker{};  // thread that waits for the signals
static_assert(std::atomic<pthread_t>::is_always_lock_free);

/// Forwards a signal. The threads of a driver or a maker's library do not block signals. Without
/// this handler the signal would end the program and leave the last force on the hand.
void pass_on(int signal) { ::pthread_kill(taker.load(), signal); }

void handle(int signal, void (*handler)(int)) noexcept {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;  // a maker's library may not handle an interrupted call
  sigemptyset(&action.sa_mask);
  ::sigaction(signal, &action, nullptr);
}

/// Waits for an event. Also pauses after a failed poll(), so that the loop does not spin.
void wait(std::array<pollfd, 3>& waiting) noexcept {
  if (::poll(waiting.data(), waiting.size(), kHousekeeping) < 0 && errno != EINTR) {
    const timespec pause{.tv_sec = 0, .tv_nsec = kHousekeeping * 1'000'000L};
    ::nanosleep(&pause, nullptr);
  }
}

void tell_of(EmergencyKey::Turned turned, RunOutlet& outlet) noexcept {
  if (turned == EmergencyKey::Turned::nothing) return;
  outlet.say(turned == EmergencyKey::Turned::stopped
                 ? "EMERGENCY STOP: all force is off; r starts again, Ctrl-C ends"
                 : "starting again: hold the hand still");
}

}  // namespace

Signals::Signals(bool records) : records_(records) {
  sigset_t set;
  sigemptyset(&set);
  if (records_) sigaddset(&set, SIGUSR1);
  for (const int signal : kEnding) sigaddset(&set, signal);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  descriptor_ = ::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
  if (descriptor_ < 0)
    throw std::system_error(errno, std::generic_category(), "cannot watch signals");
  taker.store(::pthread_self());
  for (const int signal : kEnding) handle(signal, pass_on);
  if (records_) handle(SIGUSR1, pass_on);
}

Signals::~Signals() {
  for (const int signal : kEnding) handle(signal, SIG_DFL);
  if (records_) handle(SIGUSR1, SIG_DFL);
  ::close(descriptor_);
}

Signals::PendingSignals Signals::take() const noexcept {
  PendingSignals came;
  signalfd_siginfo signal;
  while (::read(descriptor_, &signal, sizeof signal) == static_cast<ssize_t>(sizeof signal))
    (signal.ssi_signo == SIGUSR1 ? came.record : came.end) = true;
  return came;
}

void supervise_session(const Signals& signals, SessionSupervisor& session, EmergencyKey& keys,
                       RunOutlet& outlet) noexcept {
  std::array<pollfd, 3> waiting{{{signals.descriptor(), POLLIN, 0},
                                 {session.over_descriptor(), POLLIN, 0},
                                 {keys.descriptor(), POLLIN, 0}}};
  bool running = true;
  while (running) {
    wait(waiting);
    if (waiting[2].revents != 0) {
      tell_of(keys.take(), outlet);
      waiting[2].fd = keys.descriptor();
    }
    const Signals::PendingSignals came = signals.take();
    if (came.end) session.stop();
    running = session.look();
    if (came.record) session.write_flight_record("asked for");
  }
}

}  // namespace feltwire
