#include "server/app/demo_hands.hpp"

#include <fcntl.h>
#include <linux/close_range.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

namespace feltwire {

struct DemoHand {
  const char* name;
  const char* device;
  const char* local_model;
};

namespace {

// Only one has a local model, so that an admin who delays both links sees the difference.
constexpr std::array<DemoHand, 2> kHands = {{
    {"left-hand", "simulated:path=figure-eight,radius=0.03,depth=0.005,seed=1", "whole"},
    {"right-hand", "simulated:path=taps,depth=0.01,tremor=0.0002,seed=2", "off"},
}};

/// Turns the new process into the program, whose output goes to `log`. Returns errno if it cannot.
/// After fork() in a process with threads, it may only call what is safe in a signal handler.
int become_program(char* const* arguments, const char* log, pid_t parent) {
  const int input = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (input < 0 || ::dup2(input, STDIN_FILENO) < 0) return errno;
  const int output = ::open(log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (output < 0 || ::dup2(output, STDOUT_FILENO) < 0 || ::dup2(output, STDERR_FILENO) < 0)
    return errno;
  // A hand with the server's sockets would keep its ports. A kernel before 5.11 cannot close them,
  // but there too the hand ends with the server.
  ::close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
  // A group of its own: Ctrl-C in the terminal reaches the server alone, which ends the hands.
  if (::setpgid(0, 0) != 0 || ::prctl(PR_SET_PDEATHSIG, SIGTERM) != 0) return errno;
  if (::getppid() != parent) return ESRCH;  // the server has ended meanwhile
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  ::execv(arguments[0], arguments);
  return errno;
}

/// Starts a program, and returns its process. Throws std::system_error. posix_spawn() has no way to
/// let a program end with its parent.
pid_t start_program(std::vector<std::string> words, const std::filesystem::path& log) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::array<int, 2> failure{};  // carries errno; closed by the new program
  if (::pipe2(failure.data(), O_CLOEXEC) != 0)
    throw std::system_error(errno, std::generic_category());
  const pid_t parent = ::getpid(), child = ::fork();
  int error = errno;
  if (child == 0) {
    error = become_program(arguments.data(), log.c_str(), parent);
    ::_exit(::write(failure[1], &error, sizeof error) == sizeof error ? 126 : 127);
  }
  ::close(failure[1]);
  ssize_t size = child < 0 ? sizeof error : 0;
  if (child > 0) do
      size = ::read(failure[0], &error, sizeof error);
    while (size < 0 && errno == EINTR);
  ::close(failure[0]);
  if (size == 0) return child;
  if (child > 0) ::waitpid(child, nullptr, 0);
  throw std::system_error(error, std::generic_category());
}

/// "exit status 1" or "signal 9", of waitpid()'s status.
std::string ending_of(int status) {
  return WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status))
                             : "exit status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

DemoHands::DemoHands(const DemoHandsSetup& setup) : patience_(setup.patience) {
  try {
    for (const std::string& scene : setup.scenes)
      for (const DemoHand& hand : kHands) start(setup, scene, hand);
  } catch (...) {
    end();
    throw;
  }
}

void DemoHands::start(const DemoHandsSetup& setup, const std::string& scene, const DemoHand& demo) {
  const std::vector<std::string> words = {setup.client.string(),
                                          "--connect",
                                          setup.server,
                                          "--fingerprint",
                                          setup.fingerprint,
                                          "--token-file",
                                          setup.token.string(),
                                          "--scene",
                                          scene,
                                          "--name",
                                          demo.name,
                                          "--device",
                                          demo.device,
                                          "--local-model",
                                          demo.local_model,
                                          "--link",
                                          "delay=0",
                                          "--changes",
                                          "any"};
  Hand hand{0, demo.name + std::string(" of scene ") + scene,
            setup.logs / ("demo-" + std::to_string(hands_.size() + 1) + ".log")};
  hands_.reserve(hands_.size() + 1);
  try {
    hand.process = start_program(words, hand.log);
  } catch (const std::system_error& error) {
    throw std::runtime_error("--demo: cannot start " + setup.client.string() + ": " +
                             error.code().message());
  }
  hands_.push_back(std::move(hand));
}

std::vector<std::string> DemoHands::ended() {
  std::vector<std::string> lines;
  std::erase_if(hands_, [&lines](const Hand& hand) {
    int status = 0;
    if (::waitpid(hand.process, &status, WNOHANG) != hand.process) return false;
    lines.push_back(hand.what + " has ended (" + ending_of(status) + "); " + hand.log.string() +
                    " says why");
    return true;
  });
  return lines;
}

void DemoHands::end() noexcept {
  constexpr std::chrono::milliseconds kBetweenLooks{10};
  for (const Hand& hand : hands_) {
    ::kill(hand.process, SIGTERM);
    ::kill(hand.process, SIGCONT);  // a stopped one would never see it
  }
  std::chrono::milliseconds waited{0};
  for (const Hand& hand : hands_) {
    pid_t left = 0;
    while ((left = ::waitpid(hand.process, nullptr, WNOHANG)) == 0 && waited < patience_) {
      std::this_thread::sleep_for(kBetweenLooks);
      waited += kBetweenLooks;
    }
    if (left != 0) continue;
    ::kill(hand.process, SIGKILL);
    while (::waitpid(hand.process, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  hands_.clear();
}

}  // namespace feltwire
