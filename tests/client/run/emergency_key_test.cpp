// Tests the keys of a terminal, on a pseudo terminal of another process.

#include "client/run/emergency_key.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

namespace feltwire::emergency_key_test {
namespace {

constexpr int kBatches = 6;

/// Runs as the child process. It writes a letter after each batch of keys, and exits with 0 if the
/// terminal has its former settings again.
[[noreturn]] void obey() {
  const auto stop = std::make_shared<EmergencyStop>();
  termios before{}, after{};
  ::tcgetattr(STDIN_FILENO, &before);
  {
    EmergencyKey keys(stop, STDIN_FILENO);
    const auto say = [](const char* letter) { return ::write(STDOUT_FILENO, letter, 1) == 1; };
    say(keys.descriptor() >= 0 ? "+" : "-");
    int batches = 0;
    pollfd waiting{keys.descriptor(), POLLIN, 0};
    while (::poll(&waiting, 1, 10'000) == 1) {
      switch (keys.take()) {
        case EmergencyKey::Turned::stopped:
          say(stop->pressed() ? "S" : "?");
          break;
        case EmergencyKey::Turned::started:
          say(stop->pressed() ? "?" : "r");
          break;
        case EmergencyKey::Turned::nothing:
          if (keys.descriptor() < 0) ::_exit(2);  // The terminal is gone.
          say(".");
          break;
      }
      if (++batches == kBatches) break;
    }
  }
  ::tcgetattr(STDIN_FILENO, &after);
  ::_exit(before.c_lflag == after.c_lflag ? 0 : 1);
}

struct Terminal {
  Terminal() {
    child = ::forkpty(&master, nullptr, nullptr, nullptr);
    if (child == 0) obey();
  }
  ~Terminal() { ::close(master); }
  void type(const std::string& keys) const {
    ASSERT_EQ(::write(master, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  char hear() const {
    pollfd waiting{master, POLLIN, 0};
    char letter = '!';
    if (::poll(&waiting, 1, 10'000) != 1 || ::read(master, &letter, 1) != 1) return '!';
    return letter;
  }
  int master = -1;
  pid_t child = -1;
};

TEST(EmergencyKey, TheSpaceBarStopsAndRStartsAgain) {
  const Terminal terminal;
  ASSERT_EQ(terminal.hear(), '+');
  const auto answer = [&](const std::string& keys) {
    terminal.type(keys);
    return terminal.hear();
  };
  EXPECT_EQ(answer("x"), '.');
  EXPECT_EQ(answer("r"), '.');  // The hand is already started.
  EXPECT_EQ(answer(" "), 'S');
  EXPECT_EQ(answer("q"), '.');
  EXPECT_EQ(answer("r"), 'r');
  EXPECT_EQ(answer("r "), 'S');  // A stop overrides a start.
  int status = -1;
  ASSERT_EQ(::waitpid(terminal.child, &status, 0), terminal.child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST(EmergencyKey, ReadsNothingWhereThereIsNoTerminal) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  EXPECT_EQ(EmergencyKey(std::make_shared<EmergencyStop>(), ends[0]).descriptor(), -1);
  EXPECT_EQ(EmergencyKey(nullptr, ends[0]).descriptor(), -1);
  ::close(ends[0]);
  ::close(ends[1]);
}

}  // namespace
}  // namespace feltwire::emergency_key_test
