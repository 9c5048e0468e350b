// Tests the operation of a server: live counters, health, options from the environment.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "server/app/health.hpp"
#include "server/app/server.hpp"
#include "server/app/summary.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::operation_test {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::chrono::milliseconds kWait{test::kPatience};

Server room_server() {
  ServerConfig config;
  config.port = 0;
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  return {config, std::move(scenes), test::security()};
}

std::string path(const std::string& name) {
  return ::testing::TempDir() + "feltwire_" + std::to_string(::getpid()) + name;
}

/// Sets an environment variable during its life.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    ::setenv(name, value.c_str(), 1);
  }
  ~Variable() { ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
};

TEST(Operation, CountsWhileItRuns) {
  Server server = room_server();
  test::RawSocket stranger(SOCK_DGRAM, server.scenes().front().udp_port);
  stranger.send(std::vector<std::uint8_t>{1, 2, 3});
  EXPECT_TRUE(test::becomes([&] { return server.summary().front().counters.datagrams == 1; }));
  const Json scene =
      Json::parse(summary_json(server.summary(), server.control_summary())).at("scenes").at(0);
  EXPECT_EQ(scene.at("scene"), server.scenes().front().scene);
  EXPECT_EQ(scene.at("datagrams"), 1);
  EXPECT_EQ(scene.at("dropped").at("size"), 1);
  EXPECT_EQ(scene.at("dropped").at("magic"), 0);
  EXPECT_EQ(scene.at("sessions"), 0);
  server.stop();
  EXPECT_EQ(
      Json::parse(summary_json(server.summary(), server.control_summary())).at("scenes").at(0),
      scene);
}

TEST(Operation, ASummaryReplacesTheOneBefore) {
  const std::string file = path("summary.json");
  std::ofstream(file) << "old";
  write_summary(file, {}, {});
  EXPECT_EQ(Json::parse(test::text_of(file)).at("scenes"), Json::array());
  EXPECT_THAT([] { write_summary("/nonexistent/summary.json", {}, {}); },
              ::testing::ThrowsMessage<std::runtime_error>(HasSubstr("/nonexistent/summary.json")));
}

TEST(Operation, ASummaryReplacesNoPipe) {
  const std::string pipe = path("summary.pipe");
  ::unlink(pipe.c_str());
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT([&] { write_summary(pipe, {}, {}); }, ::testing::ThrowsMessage<std::runtime_error>(
                                                        HasSubstr(pipe + ": it is not a regular")));
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

/// The folder may contain temporary files of other programs.
TEST(Operation, ASummaryIsWrittenBesideWhatIsThere) {
  const std::string file = path("beside.json"), other = file + ".part";
  std::ofstream(other) << "another program's";
  write_summary(file, {}, {});
  EXPECT_EQ(test::text_of(other), "another program's");
  EXPECT_EQ(Json::parse(test::text_of(file)).at("scenes"), Json::array());
}

TEST(Operation, HealthIsAnAnswerInTime) {
  Server server = room_server();
  const int port = server.control_port();
  EXPECT_NO_THROW(check_health("127.0.0.1", port, kWait));
  // The check of a wildcard address uses this machine.
  EXPECT_NO_THROW(check_health("0.0.0.0", port, kWait));
  server.stop();
  EXPECT_THAT([&] { check_health("127.0.0.1", port, kWait); },
              ::testing::ThrowsMessage<std::runtime_error>(HasSubstr("refused")));
}

TEST(Operation, WhoListensAndSaysNothingIsNotWell) {
  const int silent = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(silent, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(silent, 1), 0);
  ASSERT_EQ(::getsockname(silent, reinterpret_cast<sockaddr*>(&address), &size), 0);
  constexpr std::chrono::milliseconds kShort{20};
  EXPECT_THAT([&] { check_health("127.0.0.1", ntohs(address.sin_port), kShort); },
              ::testing::ThrowsMessage<std::runtime_error>(HasSubstr("no answer")));
  ::close(silent);
}

TEST(Operation, TheProgramTakesItsOptionsFromTheEnvironmentAndCountsOnASignal) {
  const std::string scene = path("scene.json"), summary = path("counters.json");
  std::ofstream(scene) << R"({"name": "wall", "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})";
  const Variable from_scene("FELTWIRE_SERVER_SCENE", scene), port("FELTWIRE_SERVER_PORT", "99999"),
      file("FELTWIRE_SERVER_SUMMARY", summary);
  const Variable state("FELTWIRE_SERVER_STATE", path("state"));
  // The command line has priority.
  test::Program program(FELTWIRE_SERVER_PROGRAM, {"--port", "0"});
  EXPECT_THAT(program.line(), StartsWith("fingerprint: "));
  EXPECT_THAT(program.line(), StartsWith("listening: control tcp "));
  EXPECT_THAT(test::text_of(summary), HasSubstr("wall"));
  ASSERT_EQ(::unlink(summary.c_str()), 0);
  program.signal(SIGUSR1);
  EXPECT_TRUE(test::becomes([&] { return !test::text_of(summary).empty(); }));
  ASSERT_EQ(::unlink(summary.c_str()), 0);
  program.signal(SIGTERM);
  EXPECT_EQ(program.finish().status, 0);
  EXPECT_EQ(Json::parse(test::text_of(summary)).at("scenes").at(0).at("scene"), "wall");
}

TEST(Operation, TheProgramSaysWhetherItIsWell) {
  Server server = room_server();
  const std::string port = std::to_string(server.control_port());
  EXPECT_EQ(test::Program(FELTWIRE_SERVER_PROGRAM, {"--health", "--port", port}).finish().status,
            0);
  server.stop();
  const test::Outcome ill =
      test::Program(FELTWIRE_SERVER_PROGRAM, {"--health", "--port", port}).finish();
  EXPECT_EQ(ill.status, 1);
  EXPECT_THAT(ill.error, HasSubstr("no feltwire server answers"));
}

TEST(Operation, ACounterFileThatCannotBeIsSaidAtOnce) {
  const std::string scene = path("scene.json");
  std::ofstream(scene) << R"({"name": "wall", "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})";
  const test::Outcome outcome =
      test::Program(FELTWIRE_SERVER_PROGRAM,
                    {"--scene", scene, "--port", "0", "--summary", "/nonexistent/counters.json"})
          .finish();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_THAT(outcome.error, HasSubstr("/nonexistent/counters.json"));
}

}  // namespace
}  // namespace feltwire::operation_test
