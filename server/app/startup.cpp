#include "server/app/startup.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <memory>
#include <system_error>
#include <thread>

#include "core/base/cancellation.hpp"
#include "core/base/event_descriptor.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kPatience{1000};  // longest wait for a cancelled load to end
constexpr std::chrono::milliseconds kBetweenLines{5000};

class SignalFile {
 public:
  explicit SignalFile(int descriptor) : descriptor_(descriptor) {
    if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "startup");
  }
  ~SignalFile() { ::close(descriptor_); }
  SignalFile(const SignalFile&) = delete;
  SignalFile& operator=(const SignalFile&) = delete;
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

SignalFile signal_file() {
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGINT);
  sigaddset(&ending, SIGTERM);
  return SignalFile(::signalfd(-1, &ending, SFD_CLOEXEC));
}

/// A server start in its own thread. The thread shares the ownership of this object, because it may
/// still run after the caller has returned.
struct Launch {
  Launch(const ServerConfig& with, const web::MakePageHands& lent) : config(with), hands(lent) {}
  ServerConfig config;
  web::MakePageHands hands;
  CancellableWork work;
  EventDescriptor done;
  std::optional<Server> server;
  std::exception_ptr failure;

  void run() noexcept {
    try {
      const WorkScope doing(&work);
      server.emplace(config, hands);
    } catch (const Cancelled&) {
      // The user has cancelled the start, so there is no server.
    } catch (...) {
      failure = std::current_exception();
    }
    done.signal();
  }
};

/// Waits until the start has ended, for at most `time`. Returns whether it has ended.
bool wait_for(const Launch& start, std::chrono::milliseconds time) {
  pollfd done{start.done.get(), POLLIN, 0};
  return ::poll(&done, 1, static_cast<int>(time.count())) == 1;
}

/// Waits for at most kBetweenLines. Returns true if the start has ended, or if a signal has
/// cancelled it.
bool wait_for_end_of(Launch& start, const SignalFile& signals, StartEnded& ended) {
  std::array<pollfd, 2> files{{{start.done.get(), POLLIN, 0}, {signals.get(), POLLIN, 0}}};
  const int ready = ::poll(files.data(), files.size(), static_cast<int>(kBetweenLines.count()));
  if (ready < 0 && errno != EINTR)
    throw std::system_error(errno, std::generic_category(), "startup");
  signalfd_siginfo came{};
  if (ready > 0 && files[1].revents != 0 &&
      ::read(signals.get(), &came, sizeof came) == sizeof came) {
    ended.signal = static_cast<int>(came.ssi_signo);
    start.work.cancel();
    ended.left_behind = !wait_for(start, kPatience);
    return true;
  }
  return ready > 0 && files[0].revents != 0;
}

}  // namespace

std::optional<Server> start_server(const ServerConfig& config, StartEnded& ended,
                                   const web::MakePageHands& hands) {
  const SignalFile signals = signal_file();
  const auto start = std::make_shared<Launch>(config, hands);
  std::thread thread([start] { start->run(); });
  try {
    while (!wait_for_end_of(*start, signals, ended)) {
      spdlog::info("still loading: {}", start->work.progress());
    }
  } catch (...) {
    thread.detach();
    throw;
  }
  if (ended.left_behind) {
    thread.detach();
    return std::nullopt;
  }
  // The start has ended. Join its thread, so that the thread does not run when the program ends.
  thread.join();
  if (ended.signal != 0) return std::nullopt;
  if (start->failure) std::rethrow_exception(start->failure);
  return std::move(start->server);
}

}  // namespace feltwire
