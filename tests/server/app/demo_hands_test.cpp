// The programs that --demo starts. Small shell scripts take the place of feltwire-client.

#include "server/app/demo_hands.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/client/temporary_folder.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"

namespace feltwire::demo_hands_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A folder with a script in the place of the client.
struct Script {
  explicit Script(const std::string& commands) {
    std::ofstream(folder / "hand") << "#!/bin/sh\n" << commands << "\n";
    std::filesystem::permissions(folder / "hand", std::filesystem::perms::owner_all);
  }
  DemoHandsSetup setup() const {
    return {.client = folder / "hand",
            .server = "127.0.0.1:1",
            .fingerprint = "",
            .token = folder / "token",
            .logs = folder / "",
            .scenes = {"room"}};
  }
  std::string said() const {
    return std::filesystem::exists(folder / "demo-1.log") ? testing::text_of(folder / "demo-1.log")
                                                          : std::string();
  }
  test::TemporaryFolder folder;
};

/// The third field of /proc/PID/stat: "T" for a stopped process. Empty: there is none.
std::string state_of(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(')');
  return name_end == std::string::npos ? "" : line.substr(name_end + 2, 1);
}

bool gone(pid_t process) { return state_of(process).empty() || state_of(process) == "Z"; }

std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream file(entry.path() / "stat");
    std::string line;
    std::getline(file, line);
    if (line.rfind(')') == std::string::npos) continue;
    std::istringstream fields(line.substr(line.rfind(')') + 2));
    std::string state;
    pid_t its_parent = 0;
    fields >> state >> its_parent;
    if (its_parent == parent) children.push_back(std::stoi(name));
  }
  return children;
}

TEST(DemoHands, AHandHasNoSocketOfTheServer) {
  constexpr int kSocket = 200;
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);  // as Asio opens them
  ASSERT_EQ(::dup2(socket, kSocket), kSocket);
  ::close(socket);
  const Script script("[ -e /proc/$$/fd/200 ] && echo kept\necho looked\nexec sleep 1000");
  {
    const DemoHands hands(script.setup());
    test::eventually("it has looked",
                     [&] { return script.said().find("looked") != std::string::npos; });
  }
  ::close(kSocket);
  EXPECT_THAT(script.said(), Not(HasSubstr("kept")));
}

TEST(DemoHands, AStoppedHandEnds) {
  const Script script("trap 'echo told; exit 0' TERM\necho $$\nkill -STOP $$\nexec sleep 1000");
  DemoHands hands(script.setup());
  test::eventually("it has stopped", [&] {
    const std::string said = script.said();
    return said.find('\n') != std::string::npos && state_of(std::stoi(said)) == "T";
  });
  hands.end();
  EXPECT_THAT(script.said(), HasSubstr("told"));
}

TEST(DemoHands, AHandThatStaysIsKilled) {
  const Script script("trap '' TERM\necho $$\nexec sleep 1000");
  DemoHandsSetup setup = script.setup();
  setup.patience = std::chrono::milliseconds(50);
  DemoHands hands(setup);
  test::eventually("it runs", [&] { return script.said().find('\n') != std::string::npos; });
  const pid_t hand = std::stoi(script.said());
  hands.end();
  EXPECT_TRUE(gone(hand));
}

TEST(DemoHands, AHandThatEndsIsToldOnce) {
  const Script script("exit 3");
  DemoHands hands(script.setup());
  std::vector<std::string> told;
  test::eventually("both have ended", [&] {
    for (std::string& line : hands.ended()) told.push_back(std::move(line));
    return told.size() == 2;
  });
  EXPECT_THAT(told, ::testing::UnorderedElementsAre(
                        AllOf(HasSubstr("left-hand of scene room has ended (exit status 3)"),
                              HasSubstr("demo-1.log says why")),
                        HasSubstr("right-hand of scene room has ended")));
  EXPECT_TRUE(hands.ended().empty());
}

TEST(DemoHands, AProgramThatCannotStartIsAnError) {
  DemoHandsSetup setup = Script("exit 0").setup();  // its folder is gone now
  EXPECT_THAT(testing::error_of<std::runtime_error>([&] { const DemoHands hands(setup); }),
              AllOf(HasSubstr("--demo: cannot start "), HasSubstr("No such file")));
}

std::string scene_file(const test::TemporaryFolder& folder) {
  std::ofstream(folder / "scene.json") << R"({"name": "wall",
    "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})";
  return folder / "scene.json";
}

TEST(DemoHands, TheyEndWithAServerThatIsKilled) {
  const Script script("echo $$\nexec sleep 1000");
  const pid_t server = ::fork();
  if (server == 0) {
    const DemoHands hands(script.setup());
    for (;;) ::pause();
  }
  std::vector<pid_t> hands;
  for (const char* log : {"demo-1.log", "demo-2.log"}) {
    const std::filesystem::path file = script.folder / log;
    test::eventually("a hand runs", [&] {
      return std::filesystem::exists(file) &&
             testing::text_of(file).find('\n') != std::string::npos;
    });
    hands.push_back(std::stoi(testing::text_of(file)));
  }
  ::kill(server, SIGKILL);
  ::waitpid(server, nullptr, 0);
  for (const pid_t hand : hands) test::eventually("it has ended", [&] { return gone(hand); });
}

TEST(DemoHands, TheServerSaysWhichHandHasEnded) {
  const test::TemporaryFolder folder;
  test::Program server(FELTWIRE_SERVER_PROGRAM, {"--scene", scene_file(folder), "--port", "0",
                                                 "--demo", "--state", folder / "state"});
  server.error_until("joined scene wall");
  const std::vector<pid_t> hands = children_of(server.process());
  ASSERT_FALSE(hands.empty());
  ::kill(hands.front(), SIGKILL);
  const std::string log = server.error_until("has ended (signal 9)");
  EXPECT_THAT(log, HasSubstr("of scene wall has ended (signal 9)"));
  server.signal(SIGTERM);
  EXPECT_EQ(server.finish().status, 0);
}

/// A list of tokens from before the first start. The server then makes no token of its own.
TEST(DemoHands, WithoutTheirTokenTheServerRefuses) {
  const test::TemporaryFolder folder;
  test::Program tokens(FELTWIRE_SERVER_PROGRAM,
                       {"token", "add", "--client", "anna", "--scene", "wall", "--role", "operator",
                        "--expires", "1d", "--state", folder / "state"});
  ASSERT_EQ(tokens.finish().status, 0);
  test::Program server(FELTWIRE_SERVER_PROGRAM, {"--scene", scene_file(folder), "--port", "0",
                                                 "--demo", "--state", folder / "state"});
  const test::Outcome outcome = server.finish();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("--demo: its hands need "), HasSubstr("local.token"),
                                   HasSubstr("feltwire-server token add")));
}

}  // namespace
}  // namespace feltwire::demo_hands_test
