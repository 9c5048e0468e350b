// Tests feltwire-server as a program.

#include "tests/support/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/build_info/build_info.hpp"
#include "server/access/token_file.hpp"
#include "server/app/server.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/server/make.hpp"
#include "tests/support/help.hpp"
#include "tests/support/security.hpp"

namespace feltwire::program_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

using test::Outcome;

/// A server program with a state folder.
struct Program : test::Program {
  explicit Program(std::vector<std::string> arguments, const std::string& state = state_folder())
      : test::Program(FELTWIRE_SERVER_PROGRAM, with(std::move(arguments), state)) {}

  static std::string state_folder() {
    static const testing::TemporaryFolder folder;
    return folder / "state";
  }
  static std::vector<std::string> with(std::vector<std::string> arguments,
                                       const std::string& state) {
    arguments.insert(arguments.end(), {"--state", state});
    return arguments;
  }
};

std::string write_file(const std::string& name, const std::string& content) {
  const std::string path = ::testing::TempDir() + "feltwire_" + std::to_string(::getpid()) + name;
  std::ofstream(path) << content;
  return path;
}

std::string scene_file() {
  return write_file("scene.json", R"({"name": "wall",
    "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})");
}

void expect_one_line(const Outcome& outcome, const std::string& part) {
  EXPECT_GT(outcome.status, 0);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.error, AllOf(StartsWith("feltwire-server: "), HasSubstr(part)));
  EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
}

TEST(Program, ServesUntilItIsTold) {
  for (const int ending : {SIGINT, SIGTERM}) {
    Program program({"--scene", scene_file(), "--port", "0"});
    EXPECT_THAT(program.line(), ::testing::MatchesRegex("fingerprint: [0-9a-f]+"));
    unsigned control = 0, udp = 0;
    const std::string listening = program.line();
    EXPECT_EQ(std::sscanf(listening.c_str(), "listening: control tcp %u, scene wall udp %u",
                          &control, &udp),
              2)
        << listening;
    EXPECT_EQ(udp, control + 1);
    EXPECT_THAT(program.line(),
                ::testing::MatchesRegex("join: [^ ]*feltwire-client --connect 127.0.0.1:.*"));
    program.signal(ending);
    const Outcome outcome = program.finish();
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.out, HasSubstr("scene wall: sessions 0"));
  }
}

TEST(Program, DemoKeepsTwoHandsInItsScene) {
  Program program({"--scene", scene_file(), "--port", "0", "--demo"});
  std::string log;
  for (int joined = 0; joined < 2; ++joined) {
    log += program.error_until("joined scene wall");
    ASSERT_FALSE(program.ended()) << log;
  }
  EXPECT_THAT(log, AllOf(HasSubstr("left-hand"), HasSubstr("right-hand")));
  program.signal(SIGTERM);
  const Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, HasSubstr("scene wall: sessions 2"));
  // The hands leave before the server ends.
  EXPECT_THAT(outcome.error, HasSubstr("the client said goodbye"));
  EXPECT_THAT(outcome.error, Not(HasSubstr("the server")));
}

TEST(Program, DemoNeedsTheTokenOfTheStateFolder) {
  const std::string tokens = write_file("tokens.json", "{}");
  expect_one_line(
      Program({"--scene", scene_file(), "--demo", "--tokens", tokens}).finish(),
      "--demo: its hands have a token of the state folder and no certificate; leave --tokens");
}

TEST(Program, DemoNeedsASessionForEachHand) {
  expect_one_line(
      Program({"--scene", scene_file(), "--demo", "--max-sessions-per-client", "1"}).finish(),
      "--demo: its two hands in each of 1 scenes are of one client, which may have "
      "--max-sessions-per-client 1 sessions; raise it");
}

/// A client's name may have control characters. The log must escape them.
TEST(Program, TheLogShowsControlCharacters) {
  const testing::TemporaryFolder folder;
  Program program({"--scene", scene_file(), "--port", "0"}, folder / "state");
  const std::string first = program.line(), listening = program.line();
  unsigned port = 0;
  ASSERT_EQ(std::sscanf(listening.c_str(), "listening: control tcp %u", &port), 1);
  ServerAccess access{{"127.0.0.1", static_cast<std::uint16_t>(port)},
                      {parse_fingerprint(first.substr(first.find(' ') + 1)),
                       {},
                       {},
                       Secret(testing::text_of(folder / "state/local.token"))}};
  control::JoinRequest wanted{
      "an\x1b]0;owned\x07na\u009b2J\xff", "wall", builtin_device("simulated"), {}, Role::operator_};
  join(access, wanted, std::chrono::seconds(10));
  program.signal(SIGTERM);
  const Outcome outcome = program.finish();
  EXPECT_THAT(outcome.error, HasSubstr("an\\x1b]0;owned\\x07na\\x9b2J\\xff"));
  EXPECT_EQ(outcome.error.find_first_of("\x1b\x07"), std::string::npos) << outcome.error;
}

/// Returns the output of a program on a terminal. The program ends after it has printed `text`.
std::string on_terminal(std::vector<std::string> words, const std::string& text) {
  words.insert(words.begin(), FELTWIRE_SERVER_PROGRAM);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  int terminal = -1;
  const pid_t process = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  if (process == 0) {
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  std::string said;
  bool told = false;
  // A read error means that the program has ended.
  for (char c = 0; ::read(terminal, &c, 1) == 1;) {
    said += c;
    if (!told && said.find(text) != std::string::npos) told = ::kill(process, SIGTERM) == 0;
  }
  ::waitpid(process, nullptr, 0);
  ::close(terminal);
  return said;
}

/// The links contain tokens. Other users may read a file or a journal, so the program prints links
/// to a terminal only.
TEST(Program, PrintsTheLinkOfAnAdminOnATerminalOnly) {
  const testing::TemporaryFolder folder;
  const std::string state = folder / "state", file = state + "/admin.token";
  const std::vector<std::string> words = {"--scene", scene_file(), "--port", "0", "--web", "0"};
  {
    Program program(words, state);
    std::string said;
    while (!said.starts_with("live page: ")) said = program.line();
    EXPECT_THAT(said, Not(HasSubstr("fw_")));
    program.signal(SIGTERM);
    const Outcome outcome = program.finish();
    EXPECT_THAT(outcome.out, AllOf(Not(HasSubstr("as an admin")), Not(HasSubstr("fw_"))));
    EXPECT_THAT(outcome.error, Not(HasSubstr("fw_")));
  }
  const std::string token = testing::text_of(file);
  EXPECT_EQ(std::filesystem::status(file).permissions(), std::filesystem::perms{0600});
  const Tokens tokens = TokenFile(state + "/tokens.json").tokens();
  ASSERT_NE(authenticate(tokens, token, calendar_now()), nullptr);
  EXPECT_EQ(authenticate(tokens, token, calendar_now())->role, Role::admin);

  const std::vector<std::string> here = Program::with(words, state);
  EXPECT_THAT(on_terminal(here, "live page: "), HasSubstr("/#token=" + token + "\r\n"));
  // The program must not print a revoked token, and must not replace it.
  const std::string id = token.substr(3, token.find('_', 3) - 3);
  EXPECT_EQ(Program({"token", "revoke", id}, state).finish().status, 0);
  const std::string revoked = on_terminal(here, "live page: ");
  EXPECT_THAT(revoked, AllOf(HasSubstr("live page: "), Not(HasSubstr("as an admin"))));
  EXPECT_EQ(testing::text_of(file), token);
}

/// Without a page no link is necessary. Owners of a named token file make their own tokens.
TEST(Program, MakesNoTokenOfAnAdminThatNobodyUses) {
  const testing::TemporaryFolder folder;
  const auto serve = [&](std::vector<std::string> words) {
    Program program(std::move(words), folder / "state");
    while (!program.line().starts_with("join: ")) {
    }
    program.signal(SIGTERM);
    return program.finish().status;
  };
  EXPECT_EQ(serve({"--scene", scene_file(), "--port", "0"}), 0);
  const std::string tokens = folder / "state/tokens.json";
  EXPECT_EQ(serve({"--scene", scene_file(), "--port", "0", "--web", "0", "--tokens", tokens}), 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "state/admin.token"));
}

TEST(Program, CommandLineWinsOverTheFile) {
  scene_file();
  const std::string config = write_file(
      "server.json", R"({"scenes": [")" + scene_file() + R"("], "port": 70, "log_level": "off"})");
  Program program({"--config", config, "--port", "0"});
  EXPECT_THAT(program.line(), StartsWith("fingerprint: "));
  EXPECT_THAT(program.line(), StartsWith("listening: control tcp "));
  program.signal(SIGTERM);
  const Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.error, "");  // The file's log level still applies.
}

TEST(Program, FaultsAreOneLineAndANonZeroExit) {
  expect_one_line(Program({}).finish(), "--scene");
  expect_one_line(Program({"--scene", "/nonexistent/scene.json"}).finish(), "scene.json");
  expect_one_line(Program({"--scene", scene_file(), "--port", "99999"}).finish(), "--port");
  expect_one_line(Program({"--scene", scene_file(), "--prot", "1"}).finish(), "--prot");
  expect_one_line(Program({"--scene", scene_file(), "--address", "here"}).finish(), "--address");
  expect_one_line(Program({"--config", write_file("bad.json", "{\n\"port\": x}")}).finish(),
                  "bad.json:2");
  expect_one_line(
      Program({"--scene", write_file("bad_scene.json", "{\n}"), "--port", "0"}).finish(),
      "bad_scene.json");
}

TEST(Program, PortInUse) {
  ServerConfig config;
  config.port = 0;
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  const Server server(config, std::move(scenes), test::security());
  const std::string port = std::to_string(server.control_port());
  expect_one_line(Program({"--scene", scene_file(), "--port", port}).finish(), port);
}

TEST(Program, SaysItsVersion) {
  const Outcome outcome = Program({"--version"}).finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, build_info("feltwire-server") + "\n");
  EXPECT_THAT(outcome.out, HasSubstr(compiler()));
}

TEST(Program, HelpHasExamples) {
  const Outcome outcome = Program({"--help-all"}).finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("--silence-timeout"), HasSubstr("Examples")));
  const Outcome brief = Program({"--help"}).finish();
  EXPECT_EQ(brief.status, 0);
  EXPECT_THAT(brief.out, AllOf(HasSubstr("--scene"), HasSubstr("Examples"), HasSubstr("--help-all"),
                               Not(HasSubstr("--silence-timeout"))));
  test::expect_one_screen(brief.out);
  EXPECT_GE(test::expect_files_of_examples(FELTWIRE_SERVER_PROGRAM, {}), 3);
}

}  // namespace
}  // namespace feltwire::program_test
