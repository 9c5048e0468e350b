#include "client/run/crash_release.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <mutex>
#include <stdexcept>
#include <string>

namespace feltwire {
namespace {

constexpr std::array kCrashes = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS, SIGTRAP};
constexpr std::array kIgnored = {SIGTSTP, SIGTTIN, SIGTTOU, SIGXFSZ};
/// Nothing can handle the first two signals. The others do not end a program.
constexpr std::array kHarmless = {SIGKILL, SIGSTOP, SIGCHLD, SIGCONT, SIGURG, SIGWINCH};
/// Time [ns] in which a driver's thread executes a release() (AsyncSignalRelease).
constexpr timespec kTimeToLetGo{.tv_sec = 0, .tv_nsec = 20'000'000};

/// The devices of all CrashRelease objects.
std::array<std::atomic<Device*>, CrashRelease::kMost> devices_to_release{};
static_assert(std::atomic<Device*>::is_always_lock_free);

template <std::size_t n>
bool is_among(const std::array<int, n>& signals, int signal) noexcept {
  return std::ranges::find(signals, signal) != signals.end();
}

std::atomic<pid_t> owner{0};  // the process whose devices these are

void release_all() {
  if (owner.load() != ::getpid()) return;
  bool released = false;
  for (const std::atomic<Device*>& place : devices_to_release)
    if (Device* device = place.load()) {
      device->release();
      released = true;
    }
  if (!released) return;
  timespec left = kTimeToLetGo;
  while (::nanosleep(&left, &left) != 0 && errno == EINTR) continue;
}

void release_and_die(int signal) {
  release_all();
  ::raise(signal);
}

/// The C library reserves the signals below SIGRTMIN, and its sigaction() refuses them. Until the
/// library installs its handlers, such a signal from another program would end this program. So the
/// system call makes the kernel ignore them.
class OwnSignals {
 public:
  static constexpr int kFirst = 32;
  static void change(void (*from)(int), void (*to)(int)) noexcept {
    for (int signal = kFirst; signal < SIGRTMIN; ++signal) {
      Action action{};
      if (::syscall(SYS_rt_sigaction, signal, nullptr, &action, sizeof action.mask) != 0 ||
          action.handler != from)
        continue;
      action = {.handler = to};
      ::syscall(SYS_rt_sigaction, signal, &action, nullptr, sizeof action.mask);
    }
  }

 private:
  /// The kernel's struct sigaction on x86-64 and 64-bit ARM.
  struct Action {
    void (*handler)(int) = SIG_DFL;
    unsigned long flags = 0;
    void (*restorer)() = nullptr;
    std::uint64_t mask = 0;
  };
};

/// The handlers of all signals, and what was there before.
class Handlers {
 public:
  void take_all(bool records) noexcept {
    for (int signal = 1; signal <= SIGRTMAX; ++signal) {
      struct sigaction now {};
      const bool known = ::sigaction(signal, nullptr, &now) == 0;
      if (!known || is_among(kHarmless, signal) || (signal == SIGUSR1 && records)) continue;
      const bool ends = (now.sa_flags & SA_SIGINFO) == 0 && now.sa_handler == SIG_DFL;
      if (is_among(kIgnored, signal))
        take(signal, SIG_IGN, 0);
      else if (ends || is_among(kCrashes, signal))
        take(signal, release_and_die, SA_RESETHAND);
    }
    OwnSignals::change(SIG_DFL, SIG_IGN);
  }
  void give_back() noexcept {
    for (std::size_t signal = 1; signal < before_.size(); ++signal) {
      // A handler that the program has set meanwhile stays.
      struct sigaction now {};
      const bool ours = taken_[signal] &&
                        ::sigaction(static_cast<int>(signal), nullptr, &now) == 0 &&
                        (now.sa_handler == release_and_die || now.sa_handler == SIG_IGN);
      if (ours) ::sigaction(static_cast<int>(signal), &before_[signal], nullptr);
    }
    taken_ = {};
    OwnSignals::change(SIG_IGN, SIG_DFL);
  }

 private:
  void take(int signal, void (*handler)(int), int flags) noexcept {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigemptyset(&action.sa_mask);
    taken_[static_cast<std::size_t>(signal)] =
        ::sigaction(signal, &action, &before_[static_cast<std::size_t>(signal)]) == 0;
  }

  static constexpr std::size_t kSignals = 65;  // 1 to 64
  std::array<struct sigaction, kSignals> before_{};
  std::array<bool, kSignals> taken_{};
};

/// Guards the two below.
std::mutex mutex;
std::size_t in_use = 0;  // places of devices_to_release
Handlers handlers;

}  // namespace

CrashRelease::CrashRelease(Device& device, bool takes_sigusr1) {
  const std::lock_guard lock(mutex);
  static const bool registered = std::atexit(release_all) == 0;
  static_cast<void>(registered);
  owner.store(::getpid());
  const auto place =
      std::ranges::find(devices_to_release, nullptr, [](const auto& p) { return p.load(); });
  if (place == devices_to_release.end())
    throw std::runtime_error("this process has " + std::to_string(kMost) +
                             " hands already; close one first");
  place->store(&device);
  place_ = static_cast<std::size_t>(place - devices_to_release.begin());
  if (in_use++ == 0) handlers.take_all(takes_sigusr1);
}

CrashRelease::~CrashRelease() {
  const std::lock_guard lock(mutex);
  if (--in_use == 0) handlers.give_back();
  devices_to_release[place_].store(nullptr);
}

}  // namespace feltwire
