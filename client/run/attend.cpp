#include "client/run/attend.hpp"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <system_error>

#include "client/run/status_line.hpp"

namespace feltwire {
namespace {

constexpr int kHousekeeping = 50;  // [ms] between looks at the rings

/// Also where the system fails to wait, so that looks do not follow each other without end.
void wait(std::array<pollfd, 2>& waiting) noexcept {
  if (::poll(waiting.data(), waiting.size(), kHousekeeping) < 0 && errno != EINTR) {
    const timespec pause{.tv_sec = 0, .tv_nsec = kHousekeeping * 1'000'000L};
    ::nanosleep(&pause, nullptr);
  }
}

void show(StatusLine& line, const LiveStatus& status, const Records& records) noexcept {
  try {
    const auto sight = records.sight();
    line.show(status, sight ? text(*sight) : std::string());
  } catch (const std::exception&) {  // no memory for it: the next may have
  }
}

}  // namespace

Signals::Signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) sigaddset(&set, signal);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  descriptor_ = ::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
  if (descriptor_ < 0)
    throw std::system_error(errno, std::generic_category(), "cannot watch signals");
}

Signals::~Signals() { ::close(descriptor_); }

bool Signals::take() const noexcept {
  bool came = false;
  signalfd_siginfo signal;
  while (::read(descriptor_, &signal, sizeof signal) == static_cast<ssize_t>(sizeof signal))
    came = true;
  return came;
}

void attend(const Signals& signals, ServoThread& thread, Ring<LiveStatus>& statuses,
            Records& records, Reconnector& reconnector) noexcept {
  StatusLine line;
  bool connected = true;
  std::array<pollfd, 2> waiting{
      {{signals.descriptor(), POLLIN, 0}, {thread.over_descriptor(), POLLIN, 0}}};
  bool running = true;
  while (running) {
    wait(waiting);
    if (signals.take()) thread.stop();
    running = !thread.over();
    LiveStatus status;
    bool fresh = false;
    while (statuses.pop(status)) fresh = true;
    records.write();
    if (fresh) show(line, status, records);
    if (fresh) connected = status.connected;
    if (running) reconnector.look(connected, Reconnector::Clock::now());
    if (!reconnector.refusal().empty()) thread.stop();
  }
  line.end();
}

}  // namespace feltwire
