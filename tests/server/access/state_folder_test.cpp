// Tests the state folder: an interrupted first start, and the permission to write.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "core/base/json_document.hpp"
#include "core/base/pending_file.hpp"
#include "server/access/security.hpp"
#include "server/app/server_config.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/program.hpp"

namespace feltwire::state_folder_test {
namespace {

constexpr int kStopped = 42;
/// Remaining calls until this process stops. A negative number means no stop.
int calls_left = -1;

/// Stops the process like a power failure, before or after a call that changes the folder.
void step() {
  if (calls_left >= 0 && calls_left-- == 0) ::_exit(kStopped);
}

}  // namespace
}  // namespace feltwire::state_folder_test

// Replaces functions of the C library. Each counts a step before and a step after the call.
extern "C" int rename(const char* from, const char* to) noexcept {
  feltwire::state_folder_test::step();
  const long result = ::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
  feltwire::state_folder_test::step();
  return static_cast<int>(result);
}
extern "C" int mkdir(const char* path, mode_t mode) noexcept {
  feltwire::state_folder_test::step();
  const long result = ::syscall(SYS_mkdirat, AT_FDCWD, path, mode);
  feltwire::state_folder_test::step();
  return static_cast<int>(result);
}
extern "C" int fsync(int descriptor) {
  feltwire::state_folder_test::step();
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}
extern "C" int fchmod(int descriptor, mode_t mode) noexcept {
  feltwire::state_folder_test::step();
  return static_cast<int>(::syscall(SYS_fchmod, descriptor, mode));
}

namespace feltwire::state_folder_test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::text_of;

CalendarTime now() {
  return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

ServerConfig config_for(const fs::path& state) {
  ServerConfig config;
  config.state = state;
  return config;
}

mode_t mode_of(const fs::path& file) {
  struct stat status {};
  EXPECT_EQ(::stat(file.c_str(), &status), 0) << file;
  return status.st_mode & 0777u;
}

/// Opens the folder in a child process that stops after these steps. Returns the exit status.
int open_and_stop(const ServerConfig& config, int steps) {
  const pid_t child = ::fork();
  if (child == 0) {
    calls_left = steps;
    try {
      open_security(config);
    } catch (...) {
      ::_exit(1);
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void expect_whole(const ServerConfig& config, const std::string& where) {
  SCOPED_TRACE(where);
  const Security security = open_security(config);
  EXPECT_EQ(text_of(config.state / "fingerprint"),
            to_string(fingerprint(security.identity)) + "\n");
  const std::string local = text_of(config.state / "local.token");
  EXPECT_NE(authenticate(security.tokens.tokens(), local, now()), nullptr);
  EXPECT_EQ(security.tokens.tokens().size(), 1u);
  for (const auto& entry : fs::directory_iterator(config.state)) {
    const std::string name = entry.path().filename();
    EXPECT_THAT(name, ::testing::AnyOf("certificate.pem", "key.pem", "fingerprint", "tokens.json",
                                       "local.token", "lock", "tokens.json.lock"));
  }
  EXPECT_EQ(mode_of(config.state), 0700u);
}

TEST(StateFolder, MendsWhereverAFirstStartWasStopped) {
  int stopped = 0;
  for (int steps = 0;; ++steps) {
    const TemporaryFolder folder;
    const ServerConfig config = config_for(folder / "deep/state");
    const int status = open_and_stop(config, steps);
    expect_whole(config, "stopped after " + std::to_string(steps) + " steps");
    if (status == 0) break;
    ASSERT_EQ(status, kStopped);
    ++stopped;
  }
  // Each of five files is created, chmodded, flushed and renamed. The start also creates two
  // folders.
  EXPECT_GE(stopped, 2 * 2 + 5 * 4);
}

/// The start is interrupted twice, at any two steps.
TEST(StateFolder, MendsAfterTwoStops) {
  for (int first = 0; first < 24; first += 3)
    for (int second = 0; second < 24; second += 5) {
      const TemporaryFolder folder;
      const ServerConfig config = config_for(folder / "state");
      open_and_stop(config, first);
      open_and_stop(config, second);
      expect_whole(config, std::to_string(first) + ", then " + std::to_string(second));
    }
}

/// A later interrupted start must keep the certificate that clients trust.
TEST(StateFolder, KeepsItsCertificateWhateverIsStopped) {
  const TemporaryFolder folder;
  const ServerConfig config = config_for(folder / "state");
  const Security made = open_security(config);
  const std::string local = text_of(config.state / "local.token");
  for (int steps = 0; steps < 10; ++steps) open_and_stop(config, steps);
  const Security again = open_security(config);
  EXPECT_EQ(made.identity.certificate, again.identity.certificate);
  EXPECT_EQ(text_of(config.state / "local.token"), local);
}

/// Half of the key pair is missing, but clients trust the fingerprint of this pair. The error must
/// leave the decision to a person.
TEST(StateFolder, SaysWhatToRemove) {
  for (const auto& [gone, there] :
       {std::pair{"key.pem", "certificate.pem"}, std::pair{"certificate.pem", "key.pem"}}) {
    const TemporaryFolder folder;
    const ServerConfig config = config_for(folder / "state");
    open_security(config);
    fs::remove(config.state / gone);
    EXPECT_THAT(error_of<FileError>([&] { open_security(config); }),
                AllOf(HasSubstr((config.state / gone).string() + ": is missing"),
                      HasSubstr("remove " + (config.state / there).string())));
    fs::remove(config.state / there);
    EXPECT_NO_THROW(open_security(config));
  }
}

TEST(StateFolder, IsNoPlaceThatOthersWriteTo) {
  const TemporaryFolder folder;
  const ServerConfig config = config_for(folder / "state");
  open_security(config);
  for (const mode_t mode : {0777u, 0770u, 0702u, 01777u}) {
    ASSERT_EQ(::chmod(config.state.c_str(), mode), 0);
    EXPECT_THAT(error_of<FileError>([&] { open_security(config); }),
                HasSubstr("chmod 700 " + config.state.string()));
    EXPECT_THAT(error_of<FileError>([&] { make_state_folder(config); }), HasSubstr("chmod 700"));
  }
  for (const mode_t mode : {0755u, 0750u, 0700u}) {
    ASSERT_EQ(::chmod(config.state.c_str(), mode), 0);
    EXPECT_NO_THROW(open_security(config));
  }
  EXPECT_NO_THROW(open_security(config_for((folder / "state").string() + "/")));
}

TEST(StateFolder, TokensAreNobodyElsesToReadOrWrite) {
  const TemporaryFolder folder;
  const ServerConfig config = config_for(folder / "state");
  open_security(config);
  const fs::path tokens = config.state / "tokens.json";
  TokenFile running(tokens);
  for (const mode_t mode : {0666u, 0644u, 0620u}) {
    ASSERT_EQ(::chmod(tokens.c_str(), mode), 0);
    const auto refused = HasSubstr("chmod 600 " + tokens.string());
    EXPECT_THAT(error_of<FileError>([&] { open_security(config); }), refused);
    EXPECT_THAT(error_of<FileError>([&] { change_tokens(tokens, [](Tokens&) {}); }), refused);
    const auto said = running.refresh();
    ASSERT_TRUE(said.has_value());
    EXPECT_THAT(*said, refused);
    EXPECT_EQ(running.tokens().size(), 1u);  // The tokens must not change.
    ASSERT_EQ(::chmod(tokens.c_str(), 0600), 0);
    EXPECT_EQ(running.refresh(), std::nullopt);
  }
  EXPECT_NO_THROW(open_security(config));
}

// feltwire-server token add --out

std::vector<std::string> add_to(const fs::path& state, const std::string& out) {
  return {"token", "add",    "--state", state.string(), "--client", "anna",  "--scene",
          "*",     "--role", "admin",   "--expires",    "never",    "--out", out};
}

TEST(TokenCommand, AnOutThatCannotBeWrittenAddsNoToken) {
  const TemporaryFolder folder;
  const ServerConfig config = config_for(folder / "state");
  open_security(config);
  const std::string before = text_of(config.state / "tokens.json");
  fs::create_directory(folder / "taken");
  const std::string gone = folder / "nowhere/anna.token", taken = folder / "taken";
  for (const std::string& out : {gone, taken}) {
    const test::Outcome outcome =
        test::Program(FELTWIRE_SERVER_PROGRAM, add_to(config.state, out)).finish();
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.error, HasSubstr(out));
    EXPECT_EQ(text_of(config.state / "tokens.json"), before);
  }
}

TEST(TokenCommand, AnOutThatCanBeWrittenHasTheTokenThatWasAdded) {
  const TemporaryFolder folder;
  const ServerConfig config = config_for(folder / "state");
  const std::string out = folder / "anna.token";
  std::ofstream(out) << "old";
  const test::Outcome outcome =
      test::Program(FELTWIRE_SERVER_PROGRAM, add_to(config.state, out)).finish();
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_EQ(mode_of(out), 0600u);
  const TokenFile tokens(config.state / "tokens.json");
  const Token* anna = authenticate(tokens.tokens(), text_of(out), now());
  ASSERT_NE(anna, nullptr);
  EXPECT_EQ(anna->client, "anna");
}

/// If the token file cannot change, no text of the new token may remain.
TEST(TokenCommand, ATokenThatCannotBeStoredLeavesNoOut) {
  const TemporaryFolder folder;
  const ServerConfig config = config_for(folder / "state");
  open_security(config);
  std::ofstream(config.state / "tokens.json") << "broken";
  const std::string out = folder / "anna.token";
  EXPECT_EQ(test::Program(FELTWIRE_SERVER_PROGRAM, add_to(config.state, out)).finish().status, 1);
  EXPECT_EQ(folder.entries(), 1u);  // only the state folder
}

/// The server does not have the token's scene.
TEST(TokenCommand, AnUnknownSceneIsWarnedOfWithTheNearestName) {
  const TemporaryFolder folder;
  const std::string config = folder / "server.json";
  std::ofstream(folder / "room.json") << R"({"name": "room", "objects": []})";
  std::ofstream(folder / "table.json") << R"({"name": "table", "objects": []})";
  std::ofstream(config) << R"({"scenes": ["room.json", "table.json"], "state": "state"})";
  const auto add = [&](const std::string& scene, std::vector<std::string> more) {
    std::vector<std::string> words = {"token", "add",    "--client", "anna",      "--scene",
                                      scene,   "--role", "operator", "--expires", "never"};
    words.insert(words.end(), more.begin(), more.end());
    const test::Outcome outcome = test::Program(FELTWIRE_SERVER_PROGRAM, words).finish();
    EXPECT_EQ(outcome.status, 0) << outcome.error;
    return outcome.error;
  };
  EXPECT_THAT(add("rom", {"--config", config}),
              AllOf(HasSubstr("feltwire-server token: warning: this server has no scene 'rom'"),
                    HasSubstr("did you mean room?"), HasSubstr("room, table")));
  for (const char* known : {"room", "table", "*"}) EXPECT_EQ(add(known, {"--config", config}), "");
  // Without a configuration, the scenes of the last start count. Before a start the list is empty.
  const std::string state = folder / "state";
  EXPECT_EQ(add("rom", {"--state", state}), "");
  std::ofstream(state + "/scenes.txt") << "room\ntable\n";
  EXPECT_THAT(add("tabel", {"--state", state}), HasSubstr("did you mean table?"));
  EXPECT_EQ(add("table", {"--state", state}), "");
}

}  // namespace
}  // namespace feltwire::state_folder_test
