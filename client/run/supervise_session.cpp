#include "client/run/supervise_session.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <string>
#include <system_error>

#include "client/run/emergency_key.hpp"
#include "client/run/status_line.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

constexpr int kHousekeeping = 50;  // [ms] between checks of the rings
const std::string kLost = "the session was lost";

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

void show(StatusLine& line, const LiveStatus& status, const Records& records,
          const SceneFetch& fetch) noexcept {
  try {
    const auto sight = records.sight();
    std::string more = sight ? text(*sight) : std::string();
    if (!fetch.refusal().empty()) more += "  contact not computed here";
    line.show(status, more);
  } catch (const std::exception&) {  // no memory for this message
  }
}

/// Reports and records the applied and refused changes of an admin.
void tell_of(Changes& changes, StatusLine& line, Records& records,
             Reconnector& reconnector) noexcept {
  while (const Changes::Done* done = changes.next(reconnector.sessions())) try {
      const bool taken = done->refusal.empty();
      // Update the law of the reconnector first. A new session with the wrong law is worse than a
      // missing message.
      if (taken && done->prepared.law) reconnector.put_law(changes.law());
      line.end();
      std::fprintf(stderr, "feltwire-client: an admin changes this session: %s%s%s\n",
                   visible(done->what).c_str(),
                   taken ? "" : "; refused: ", visible(done->refusal).c_str());
      records.note({{"what", done->what},
                    {"answer", taken ? "taken" : "refused"},
                    {"refusal", done->refusal}});
    } catch (const std::exception&) {  // no memory for the text
    }
}

/// Reports once why the client does not use the fetched data.
void tell_of(const SceneFetch& fetch, std::string& told, StatusLine& line) noexcept {
  if (fetch.refusal() == told) return;
  try {
    told = fetch.refusal();
    if (told.empty()) return;
    line.end();
    std::fprintf(stderr, "feltwire-client: warning: %s\n", visible(told).c_str());
  } catch (const std::exception&) {  // no memory for the text
  }
}

void tell_of(EmergencyKey::Turned turned, StatusLine& line) noexcept {
  if (turned == EmergencyKey::Turned::nothing) return;
  line.end();
  std::fputs(
      turned == EmergencyKey::Turned::stopped
          ? "feltwire-client: EMERGENCY STOP: all force is off; r starts again, Ctrl-C ends\n"
          : "feltwire-client: starting again: hold the hand still\n",
      stderr);
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

void supervise_session(const Signals& signals, ServoThread& thread, Ring<LiveStatus>& statuses,
                       Records& records, Changes& changes, Reconnector& reconnector,
                       SceneFetch& fetch, std::uint64_t session, EmergencyKey& keys) noexcept {
  StatusLine line;
  std::string told;  // last message about fetched data
  bool connected = true;
  std::array<pollfd, 3> waiting{{{signals.descriptor(), POLLIN, 0},
                                 {thread.over_descriptor(), POLLIN, 0},
                                 {keys.descriptor(), POLLIN, 0}}};
  bool running = true;
  while (running) {
    wait(waiting);
    if (waiting[2].revents != 0) {
      tell_of(keys.take(), line);
      waiting[2].fd = keys.descriptor();
    }
    const Signals::PendingSignals came = signals.take();
    if (came.end) thread.stop();
    running = !thread.over();
    LiveStatus status;
    bool fresh = false;
    while (statuses.pop(status)) fresh = true;
    records.write();
    if (came.record) {
      line.end();
      records.tell_of_flight_record("asked for");
    }
    tell_of(changes, line, records, reconnector);
    if (fresh) show(line, status, records, fetch);
    const bool lost = fresh && connected && !status.connected;
    if (fresh) connected = status.connected;
    if (running) reconnector.look(connected, Reconnector::Clock::now());
    if (fresh) fetch.in_use(status.fetched);
    if (session != 0 && reconnector.session() != 0) session = reconnector.session();
    if (running && fresh && connected)
      fetch.look({session, status.reloads}, SceneFetch::Clock::now());
    tell_of(fetch, told, line);
    if (lost) {
      line.end();
      records.tell_of_flight_record(kLost);
    }
    if (!reconnector.refusal().empty()) thread.stop();
  }
  line.end();
}

}  // namespace feltwire
