#include "client/run/crash_release.hpp"

#include <array>
#include <atomic>
#include <csignal>

namespace feltwire {
namespace {

constexpr std::array kDeadly = {SIGSEGV, SIGBUS,  SIGFPE,    SIGILL,  SIGABRT, SIGSYS, SIGTRAP,
                                SIGXCPU, SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2};
constexpr std::array kIgnored = {SIGTSTP, SIGTTIN, SIGTTOU, SIGXFSZ};

std::atomic<Device*> device_to_release{nullptr};
static_assert(std::atomic<Device*>::is_always_lock_free);

void release_and_die(int signal) {
  if (Device* device = device_to_release.load()) device->release();
  // As if there were no handler: SA_RESETHAND has put the default back.
  ::raise(signal);
}

void handle(int signal, void (*handler)(int), int flags) noexcept {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  ::sigaction(signal, &action, nullptr);
}

}  // namespace

CrashRelease::CrashRelease(Device& device, bool records) noexcept : records_(records) {
  device_to_release.store(&device);
  for (const int signal : kDeadly)
    if (signal != SIGUSR1 || !records_) handle(signal, release_and_die, SA_RESETHAND);
  for (const int signal : kIgnored) handle(signal, SIG_IGN, 0);
}

CrashRelease::~CrashRelease() {
  for (const int signal : kDeadly)
    if (signal != SIGUSR1 || !records_) handle(signal, SIG_DFL, 0);
  for (const int signal : kIgnored) handle(signal, SIG_DFL, 0);
  device_to_release.store(nullptr);
}

}  // namespace feltwire
