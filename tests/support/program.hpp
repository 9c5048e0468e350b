#pragma once
// A program of ours as a user sees it: a separate process.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace feltwire::test {

struct Outcome {
  int status = -1;
  std::string out, error;

  /// Whether the client's force was ended because the machine did not run its servo thread. On a
  /// busy machine without permission for real-time scheduling this is no fault of the client.
  bool stalled() const {
    return error.find("the servo loop broke off") != std::string::npos ||
           error.find("in a tick that held its force for") != std::string::npos;
  }
};

/// The program with its two outputs in pipes.
class Program {
 public:
  Program(const std::string& program, std::vector<std::string> arguments) {
    // A program's default files, such as flight records, go into a folder of this test program. It
    // is removed at the end.
    static const TemporaryFolder kState;
    ::setenv("XDG_STATE_HOME", (kState / "state").c_str(), 0);
    int out[2], error[2];
    if (::pipe(out) != 0 || ::pipe(error) != 0) throw std::runtime_error("no pipe");
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(out[1], STDOUT_FILENO);
      ::dup2(error[1], STDERR_FILENO);
      // Close the test's other files: a socket that stays open would keep listening.
      ::close_range(STDERR_FILENO + 1, ~0U, 0);
      // A busy machine must not end a session. Tests of the watchdog set this option themselves.
      ::setenv("FELTWIRE_CLIENT_LET_GO_AFTER", "0.1", 0);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(out[1]);
    ::close(error[1]);
    out_ = out[0];
    error_ = error[0];
  }
  ~Program() {
    if (!ended_) {
      ::kill(process_, SIGKILL);
      finish();
    }
    ::close(out_);
    ::close(error_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  std::string line() {
    std::string text;
    char c = 0;
    while (::read(out_, &c, 1) == 1 && c != '\n') text += c;
    return text;
  }
  pid_t process() const { return process_; }
  /// The log up to `text`, or up to the end of the program.
  std::string error_until(const std::string& text) {
    std::string said;
    for (char c = 0; said.find(text) == std::string::npos && ::read(error_, &c, 1) == 1;) said += c;
    return said;
  }
  /// Whether the program has ended; finish() tells how.
  bool ended() const {
    siginfo_t ending{};
    return ::waitid(P_PID, static_cast<id_t>(process_), &ending, WEXITED | WNOHANG | WNOWAIT) ==
               0 &&
           ending.si_pid == process_;
  }
  void signal(int number) { ::kill(process_, number); }
  Outcome finish() {
    Outcome outcome;
    outcome.out = rest(out_);
    outcome.error = rest(error_);
    int status = 0;
    ::waitpid(process_, &status, 0);
    ended_ = true;
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    return outcome;
  }

 private:
  static std::string rest(int file) {
    std::string text;
    char buffer[512];
    for (ssize_t size; (size = ::read(file, buffer, sizeof buffer)) > 0;)
      text.append(buffer, static_cast<std::size_t>(size));
    return text;
  }
  pid_t process_ = -1;
  int out_ = -1, error_ = -1;
  bool ended_ = false;
};

}  // namespace feltwire::test
