// A program (feltwire-client or feltwire-server) preloads this library. The library counts each
// place that requests memory or makes a system call, or makes such a call fail once. The library
// also logs the commands to the client's simulated device.
//
// FELTWIRE_FAULT_LOG    file of a Log's size for the results
// FELTWIRE_FAULT_PLACE  hash of the place that fails; none: counts places
// FELTWIRE_FAULT_NTH    number of the failing call from there
// FELTWIRE_FAULT_TRACE  file for the stack of the failing call
//
// The library starts with main(), after the dynamic loader and the static initializers.

#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>
#include <unwind.h>

#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>

#include "client/device/device.hpp"
#include "tests/fault/fault_log.hpp"

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

using feltwire::fault::Log;

Log* file = nullptr;
std::atomic<bool> armed{false};
std::uint64_t wanted_place = 0, wanted_nth = 1;
std::atomic<std::uint64_t> calls_from_wanted{0};
int trace_file = -1;
// The library does not count its own calls.
thread_local bool inside __attribute__((tls_model("initial-exec"))) = false;

std::int64_t now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * 1'000'000'000LL + t.tv_nsec;
}

/// Return addresses relative to the base of their module. These addresses are equal in each
/// process.
struct Stack {
  static constexpr int kDeepest = 14, kOwn = 3;  // kOwn: number of frames of this library
  std::uint64_t hash = 1469598103934665603ull;
  int depth = 0;
};

_Unwind_Reason_Code visit(_Unwind_Context* context, void* data) {
  auto& stack = *static_cast<Stack*>(data);
  if (++stack.depth <= Stack::kOwn) return _URC_NO_REASON;
  const auto address = reinterpret_cast<void*>(_Unwind_GetIP(context));
  dl_find_object found{};
  if (address == nullptr || _dl_find_object(address, &found) != 0) return _URC_END_OF_STACK;
  const auto offset = reinterpret_cast<std::uintptr_t>(address) -
                      reinterpret_cast<std::uintptr_t>(found.dlfo_map_start);
  stack.hash = (stack.hash ^ offset) * 1099511628211ull;
  return stack.depth < Stack::kDeepest + Stack::kOwn ? _URC_NO_REASON : _URC_END_OF_STACK;
}

void count(std::uint64_t hash, std::uint64_t call) {
  for (std::uint64_t i = hash, tries = 0; tries < Log::kPlaces; ++i, ++tries) {
    auto& place = file->places[i % Log::kPlaces];
    std::uint64_t expected = 0;
    if (place.hash.load() == hash || place.hash.compare_exchange_strong(expected, hash) ||
        expected == hash) {
      place.call = call;
      ++place.count;
      return;
    }
  }
  ++file->overflow;
}

void trace() {
  if (trace_file < 0) return;
  constexpr int kDeepest = 40;
  std::array<void*, kDeepest> calls{};
  ::backtrace_symbols_fd(calls.data(), ::backtrace(calls.data(), kDeepest), trace_file);
}

/// Returns true if this call must fail.
[[gnu::noinline]] bool fails(std::uint64_t call) {
  if (!armed.load(std::memory_order_relaxed) || inside) return false;
  inside = true;
  const int error = errno;
  Stack stack;
  stack.hash ^= call * 0x9e3779b97f4a7c15ull;
  _Unwind_Backtrace(visit, &stack);
  bool fail = false;
  if (wanted_place == 0) {
    count(stack.hash, call);
  } else if (stack.hash == wanted_place && ++calls_from_wanted == wanted_nth) {
    fail = true;
    file->injected_at = now();
    ++file->injected;
    trace();
  }
  errno = error;
  inside = false;
  return fail;
}

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

// Functions for the client's simulated device.

void told(double force) {
  const std::int64_t at = now();
  if (file->force.load() > 0.0) {
    const std::int64_t held = at - file->told_at.load();
    if (held > file->longest_hold.load()) file->longest_hold = held;
  }
  file->told_at = at;
  file->force = force;
  if (force > file->largest.load()) file->largest = force;
  ++file->told;
}

using Write = feltwire::Command (*)(void*, const feltwire::Command&);
using Release = void (*)(void*);
Write device_write = nullptr;
Release device_release = nullptr;

/// The devices of the rehearsal have no hand. The thread of these devices has idle priority.
bool is_in_a_hand() {
  thread_local const bool idle = ::sched_getscheduler(0) == SCHED_IDLE;
  return !idle;
}

feltwire::Command write_and_tell(void* self, const feltwire::Command& on_hand) {
  feltwire::Command held = device_write(self, on_hand);
  if (is_in_a_hand()) told(held.force().norm());
  return held;
}
void release_and_tell(void* self) {
  device_release(self);
  if (is_in_a_hand()) told(0.0);
}

/// Replaces the functions in the device's virtual table. The program must export the symbol of this
/// table (link option --export-dynamic).
void follow_device() {
  auto** table = static_cast<void**>(::dlsym(RTLD_DEFAULT, "_ZTVN8feltwire15SimulatedDeviceE"));
  void* write = ::dlsym(RTLD_DEFAULT, "_ZN8feltwire10HandDevice5writeERKNS_12BasicCommandIdEE");
  void* release = ::dlsym(RTLD_DEFAULT, "_ZN8feltwire10HandDevice7releaseEv");
  if (table == nullptr || write == nullptr || release == nullptr) return;
  device_write = reinterpret_cast<Write>(write);
  device_release = reinterpret_cast<Release>(release);
  constexpr int kEntries = 12;
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = reinterpret_cast<std::uintptr_t>(table) & ~(page - 1);
  ::mprotect(reinterpret_cast<void*>(begin), 2 * page, PROT_READ | PROT_WRITE);
  for (int i = 0; i < kEntries; ++i) {
    if (table[i] == write) table[i] = reinterpret_cast<void*>(write_and_tell);
    if (table[i] == release) {
      table[i] = reinterpret_cast<void*>(release_and_tell);
      break;  // After this last entry another table follows.
    }
  }
}

int (*real_main)(int, char**, char**) = nullptr;

int begin_with_main(int argc, char** argv, char** environment) {
  inside = true;
  const char* name = std::getenv("FELTWIRE_FAULT_LOG");
  const int descriptor = name != nullptr ? ::open(name, O_RDWR | O_CLOEXEC) : -1;
  if (descriptor >= 0) {
    void* memory = ::mmap(nullptr, sizeof(Log), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    ::close(descriptor);
    if (memory != MAP_FAILED) file = static_cast<Log*>(memory);
  }
  if (file == nullptr) ::_exit(99);
  if (const char* place = std::getenv("FELTWIRE_FAULT_PLACE"))
    wanted_place = std::strtoull(place, nullptr, 16);
  if (const char* nth = std::getenv("FELTWIRE_FAULT_NTH"))
    wanted_nth = std::strtoull(nth, nullptr, 10);
  if (const char* trace = std::getenv("FELTWIRE_FAULT_TRACE"))
    trace_file = ::open(trace, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  follow_device();
  ::unsetenv("LD_PRELOAD");
  inside = false;
  armed = wanted_place != 1;
  const int code = real_main(argc, argv, environment);
  armed = false;
  return code;
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(),
                      void (*fini)(), void (*rtld_fini)(), void* stack_end) {
  real_main = main;
  using Start =
      int(int (*)(int, char**, char**), int, char**, void (*)(), void (*)(), void (*)(), void*);
  return real<Start>("__libc_start_main")(begin_with_main, argc, argv, init, fini, rtld_fini,
                                          stack_end);
}

// The numbers are indices of CALLS in run.py.
void* malloc(std::size_t size) {
  if (!fails(0)) return __libc_malloc(size);
  errno = ENOMEM;
  return nullptr;
}
void* calloc(std::size_t count, std::size_t size) {
  if (!fails(1)) return __libc_calloc(count, size);
  errno = ENOMEM;
  return nullptr;
}
void* realloc(void* memory, std::size_t size) {
  if (size == 0 || !fails(2)) return __libc_realloc(memory, size);
  errno = ENOMEM;
  return nullptr;
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  if (!fails(3)) return __libc_memalign(alignment, size);
  errno = ENOMEM;
  return nullptr;
}
void* memalign(std::size_t alignment, std::size_t size) {
  if (!fails(3)) return __libc_memalign(alignment, size);
  errno = ENOMEM;
  return nullptr;
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  if (fails(3)) return ENOMEM;
  *memory = __libc_memalign(alignment, size);
  return *memory != nullptr ? 0 : ENOMEM;
}

#define FELTWIRE_FAIL(index, error, type, name, parameters, arguments) \
  type name parameters {                                               \
    static auto* const original = real<type parameters>(#name);        \
    if (fails(index)) {                                                \
      errno = error;                                                   \
      return static_cast<type>(-1);                                    \
    }                                                                  \
    return original arguments;                                         \
  }

FELTWIRE_FAIL(4, EMFILE, int, socket, (int a, int b, int c), (a, b, c))
FELTWIRE_FAIL(5, ENETUNREACH, int, connect, (int a, const sockaddr* b, socklen_t c), (a, b, c))
FELTWIRE_FAIL(6, EADDRINUSE, int, bind, (int a, const sockaddr* b, socklen_t c), (a, b, c))
FELTWIRE_FAIL(7, EADDRINUSE, int, listen, (int a, int b), (a, b))
FELTWIRE_FAIL(8, EMFILE, int, accept, (int a, sockaddr* b, socklen_t* c), (a, b, c))
FELTWIRE_FAIL(8, EMFILE, int, accept4, (int a, sockaddr* b, socklen_t* c, int d), (a, b, c, d))
FELTWIRE_FAIL(9, ENOBUFS, ssize_t, send, (int a, const void* b, size_t c, int d), (a, b, c, d))
FELTWIRE_FAIL(9, ENOBUFS, ssize_t, sendto,
              (int a, const void* b, size_t c, int d, const sockaddr* e, socklen_t f),
              (a, b, c, d, e, f))
FELTWIRE_FAIL(9, ENOBUFS, ssize_t, sendmsg, (int a, const msghdr* b, int c), (a, b, c))
FELTWIRE_FAIL(9, ENOBUFS, int, sendmmsg, (int a, mmsghdr* b, unsigned c, int d), (a, b, c, d))
FELTWIRE_FAIL(10, ENOMEM, ssize_t, recv, (int a, void* b, size_t c, int d), (a, b, c, d))
FELTWIRE_FAIL(10, ENOMEM, ssize_t, recvfrom,
              (int a, void* b, size_t c, int d, sockaddr* e, socklen_t* f), (a, b, c, d, e, f))
FELTWIRE_FAIL(10, ENOMEM, ssize_t, recvmsg, (int a, msghdr* b, int c), (a, b, c))
FELTWIRE_FAIL(10, ENOMEM, int, recvmmsg, (int a, mmsghdr* b, unsigned c, int d, timespec* e),
              (a, b, c, d, e))
FELTWIRE_FAIL(11, ENOMEM, int, poll, (pollfd * a, nfds_t b, int c), (a, b, c))
FELTWIRE_FAIL(11, ENOMEM, int, ppoll, (pollfd * a, nfds_t b, const timespec* c, const sigset_t* d),
              (a, b, c, d))
FELTWIRE_FAIL(12, EMFILE, int, epoll_create1, (int a), (a))
FELTWIRE_FAIL(12, EMFILE, int, epoll_create, (int a), (a))
FELTWIRE_FAIL(13, ENOMEM, int, epoll_ctl, (int a, int b, int c, epoll_event* d), (a, b, c, d))
FELTWIRE_FAIL(14, EINTR, int, epoll_wait, (int a, epoll_event* b, int c, int d), (a, b, c, d))
FELTWIRE_FAIL(15, EMFILE, int, eventfd, (unsigned a, int b), (a, b))
FELTWIRE_FAIL(16, EMFILE, int, signalfd, (int a, const sigset_t* b, int c), (a, b, c))
FELTWIRE_FAIL(17, EMFILE, int, timerfd_create, (int a, int b), (a, b))
FELTWIRE_FAIL(18, EINVAL, int, timerfd_settime, (int a, int b, const void* c, void* d),
              (a, b, c, d))
FELTWIRE_FAIL(19, EIO, ssize_t, read, (int a, void* b, size_t c), (a, b, c))
FELTWIRE_FAIL(20, ENOSPC, ssize_t, write, (int a, const void* b, size_t c), (a, b, c))
FELTWIRE_FAIL(20, ENOSPC, ssize_t, writev, (int a, const iovec* b, int c), (a, b, c))
FELTWIRE_FAIL(19, EIO, ssize_t, readv, (int a, const iovec* b, int c), (a, b, c))
FELTWIRE_FAIL(21, EIO, int, fsync, (int a), (a))
FELTWIRE_FAIL(22, EIO, int, rename, (const char* a, const char* b), (a, b))
FELTWIRE_FAIL(23, ENOMEM, ssize_t, getrandom, (void* a, size_t b, unsigned c), (a, b, c))
FELTWIRE_FAIL(24, ENOBUFS, int, setsockopt, (int a, int b, int c, const void* d, socklen_t e),
              (a, b, c, d, e))
FELTWIRE_FAIL(25, ENOBUFS, int, getsockopt, (int a, int b, int c, void* d, socklen_t* e),
              (a, b, c, d, e))
FELTWIRE_FAIL(26, ENOBUFS, int, getsockname, (int a, sockaddr* b, socklen_t* c), (a, b, c))
FELTWIRE_FAIL(27, ENOTCONN, int, getpeername, (int a, sockaddr* b, socklen_t* c), (a, b, c))
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"  // flock is also the name of a struct.
FELTWIRE_FAIL(28, EIO, int, flock, (int a, int b), (a, b))
#pragma GCC diagnostic pop
FELTWIRE_FAIL(29, EIO, int, fchmod, (int a, mode_t b), (a, b))
FELTWIRE_FAIL(30, ENOMEM, int, mlockall, (int a), (a))

void* mmap(void* a, size_t b, int c, int d, int e, off_t f) {
  static auto* const original = real<void*(void*, size_t, int, int, int, off_t)>("mmap");
  if (!fails(31)) return original(a, b, c, d, e, f);
  errno = ENOMEM;
  return MAP_FAILED;
}

#define FELTWIRE_OPEN(name)                                                \
  int name(const char* path, int flags, ...) {                             \
    va_list more;                                                          \
    va_start(more, flags);                                                 \
    const mode_t mode = va_arg(more, mode_t);                              \
    va_end(more);                                                          \
    static auto* const original = real<int(const char*, int, ...)>(#name); \
    if (!fails(32)) return original(path, flags, mode);                    \
    errno = EMFILE;                                                        \
    return -1;                                                             \
  }
FELTWIRE_OPEN(open)
FELTWIRE_OPEN(open64)

int openat(int folder, const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = va_arg(more, mode_t);
  va_end(more);
  static auto* const original = real<int(int, const char*, int, ...)>("openat");
  if (!fails(32)) return original(folder, path, flags, mode);
  errno = EMFILE;
  return -1;
}
#define FELTWIRE_FOPEN(name)                                                    \
  FILE* name(const char* path, const char* how) {                               \
    static auto* const original = real<FILE*(const char*, const char*)>(#name); \
    if (!fails(33)) return original(path, how);                                 \
    errno = EMFILE;                                                             \
    return nullptr;                                                             \
  }
FELTWIRE_FOPEN(fopen)
FELTWIRE_FOPEN(fopen64)

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                   void* argument) {
  static auto* const original =
      real<int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create");
  if (fails(34)) return EAGAIN;
  return original(thread, attributes, start, argument);
}

}  // extern "C"
