// A system call fails in feltwire-client. Tests the exit status and the files of the program.

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/pending_file.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/peer.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"

namespace feltwire::program_fault_test {
namespace {

using testing::kPatience;
using testing::text_of;

/// Returns the number of open descriptors of a process.
rlim_t open_descriptors(pid_t process) {
  const std::filesystem::directory_iterator all("/proc/" + std::to_string(process) + "/fd");
  return static_cast<rlim_t>(std::distance(begin(all), end(all)));
}

class ClientProgramFault : public ::testing::Test {
 protected:
  ClientProgramFault() {
    change_tokens(tokens_, [&](Tokens& tokens) {
      tokens = {test::admin_token().token, anna_.token};
    });
    replace_file(folder_ / "token", anna_.text.text(), kPrivate);
    start_server(0);
    access_ = test::access(server_->control_port());
  }
  void start_server(std::uint16_t port) {
    ServerConfig config = testing::any_ports();
    config.port = port;
    std::vector<Scene> scenes;
    scenes.push_back(testing::floor_scene());
    server_ = std::make_unique<Server>(config, std::move(scenes),
                                       Security{test::identity(), {}, TokenFile(tokens_)});
  }
  std::unique_ptr<test::Program> start(std::vector<std::string> more) {
    more.insert(more.begin(),
                {"--connect", to_string(access_.endpoint), "--scene", "floor", "--token-file",
                 folder_ / "token", "--fingerprint", to_string(server_->fingerprint()), "--report",
                 folder_ / "report.json", "--record", folder_ / "felt.csv"});
    return std::make_unique<test::Program>(FELTWIRE_CLIENT_PROGRAM, std::move(more));
  }
  /// Waits until the last row of the recording has a force on the hand.
  void await_force() {
    for (bool pulls = false; !pulls; std::this_thread::yield()) {
      std::string rows = text_of(folder_ / "felt.csv");
      rows.erase(std::min(rows.size(), rows.rfind('\n')));
      const std::string row = rows.substr(rows.rfind('\n') + 1);
      const std::string up_to_age = row.substr(0, row.rfind(','));
      pulls = std::atof(up_to_age.substr(up_to_age.rfind(',') + 1).c_str()) > 0.5;
    }
  }
  nlohmann::json report() { return nlohmann::json::parse(text_of(folder_ / "report.json")); }

  testing::TemporaryFolder folder_;
  const std::filesystem::path tokens_ = folder_ / "tokens.json";
  IssuedToken anna_ = issue_token("anna", "*", Role::operator_, std::nullopt);
  std::unique_ptr<Server> server_;
  ServerAccess access_;
};

/// No attempt to rejoin gets a descriptor. Each attempt fails, and the run ends after the reconnect
/// time.
TEST_F(ClientProgramFault, WithoutDescriptorsALostSessionEndsInOrder) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "the sanitizer itself needs descriptors to look at an object's type";
#endif
  const auto program = start({"--hold-time", "1", "--reconnect", "1.5"});
  await_force();
  const rlim_t all = open_descriptors(program->process());
  const rlimit limit{all, all};
  ASSERT_EQ(::prlimit(program->process(), RLIMIT_NOFILE, &limit, nullptr), 0);
  server_->stop();
  const test::Outcome outcome = program->finish();
  EXPECT_EQ(outcome.status, 1) << outcome.error;
  EXPECT_THAT(outcome.error, ::testing::HasSubstr("the server ended the session"));
  EXPECT_EQ(report()["end"], "server_goodbye");
  EXPECT_EQ(report()["disconnections"], 1);
  EXPECT_GT(report()["max_force_n"], 0.5);
}

/// The last line must not show a whole run if the server went away in the middle.
TEST_F(ClientProgramFault, ARunThatIsOverWithoutItsSessionSaysSo) {
  const auto program = start({"--hold-time", "1", "--duration", "4"});
  await_force();
  server_->stop();
  const test::Outcome outcome = program->finish();
  EXPECT_EQ(outcome.status, 1) << outcome.error;
  for (const std::string& told : {outcome.out, outcome.error})
    EXPECT_THAT(told, ::testing::ContainsRegex("the session was lost at [0-9.]+ s, and not found "
                                               "again: the server ended the session: it is "
                                               "shutting down"));
  EXPECT_EQ(report()["end"], "duration");
  EXPECT_EQ(report()["disconnections"], 1);
}

/// The program cannot wait for the thread that requests a session. The program must end at once.
TEST_F(ClientProgramFault, ACheckThatEndsWhileItLooksForTheServerSaysWhatItFound) {
  test::Program program(FELTWIRE_CLIENT_PROGRAM,
                        {"--connect", to_string(access_.endpoint), "--check", "--duration", "600",
                         "--reconnect", "600", "--token-file", folder_ / "token", "--fingerprint",
                         to_string(server_->fingerprint())});
  test::eventually("the session of the check",
                   [&] { return server_->summary().front().sessions == 1; });
  const std::uint16_t port = access_.endpoint.port;
  server_->stop();
  server_.reset();
  const testing::LocalSocket deaf(SOCK_STREAM, port);
  ASSERT_EQ(::listen(deaf.descriptor(), 1), 0);
  // The server never answers this connection.
  const int asked = ::accept(deaf.descriptor(), nullptr, nullptr);
  ASSERT_GE(asked, 0);
  program.signal(SIGINT);
  const test::Outcome outcome = program.finish();
  ::close(asked);
  for (const char* finding : {"session", "round trip", "datagram size"})
    EXPECT_THAT(outcome.out, ::testing::HasSubstr(finding));
}

/// A hang-up of the terminal or its quit key must end a session in order.
TEST_F(ClientProgramFault, AHangUpEndsItInOrder) {
  for (const int signal : {SIGHUP, SIGQUIT}) {
    const auto program = start({});
    await_force();
    program->signal(signal);
    const test::Outcome outcome = program->finish();
    EXPECT_EQ(outcome.status, 0) << outcome.error;
    EXPECT_EQ(report()["end"], "requested");
    std::filesystem::remove(folder_ / "felt.csv");
  }
}

}  // namespace
}  // namespace feltwire::program_fault_test
