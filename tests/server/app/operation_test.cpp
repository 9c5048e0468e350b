// Tests the operation of a server: live counters, health, options from the environment.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <spdlog/details/log_msg.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <thread>

#include "server/app/health.hpp"
#include "server/app/log_format.hpp"
#include "server/app/server.hpp"
#include "server/app/summary.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"
#include "tests/support/text_of.hpp"
#include "tests/support/tls.hpp"

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

TEST(Operation, CountersHaveAPortWithoutThePage) {
  ServerConfig config;
  config.port = 0;
  config.metrics = "0";
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  Server server(config, std::move(scenes), test::security());
  EXPECT_EQ(server.web_url(), "");
  const std::string url = server.metrics_url();
  ASSERT_THAT(url, StartsWith("http://127.0.0.1:"));
  test::RawSocket scraper(SOCK_STREAM,
                          static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1))));
  const std::string question = "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  scraper.send({reinterpret_cast<const std::uint8_t*>(question.data()), question.size()});
  std::string answer;
  for (auto part = scraper.receive(); !part.empty(); part = scraper.receive())
    answer.append(part.begin(), part.end());
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(answer, HasSubstr("feltwire_sessions{scene=\"room\"} 0\n"));
}

/// Beyond this machine the counters need TLS and a token.
TEST(Operation, ThePortOfTheCountersIsEncryptedBeyondThisMachine) {
  ServerConfig config;
  config.port = 0;
  config.metrics = "0.0.0.0:0";
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  Server server(config, std::move(scenes), test::security());
  const std::string url = server.metrics_url();
  ASSERT_THAT(url, StartsWith("https://"));
  const auto port = static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  const test::TlsContext context = test::client_context();
  const auto bytes = [](const std::string& text) {
    return std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  };
  const auto asked = [&](const std::string& header) {
    test::RawSocket socket(SOCK_STREAM, port);
    test::TlsConnection scraper(context.get(), socket.descriptor());
    EXPECT_TRUE(scraper.connect());
    const std::string question =
        "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n" + header +
        "\r\n";
    EXPECT_TRUE(scraper.write(bytes(question)));
    constexpr std::size_t kMost = std::size_t{1} << 20;  // It closes the connection before.
    const auto answer = scraper.read(kMost);
    return std::string(answer.begin(), answer.end());
  };
  const auto without = asked("");
  EXPECT_THAT(without, StartsWith("HTTP/1.1 401 "));
  EXPECT_THAT(without, ::testing::Not(HasSubstr("feltwire_sessions")));
  EXPECT_THAT(asked("Authorization: Bearer fw_wrong\r\n"), StartsWith("HTTP/1.1 401 "));
  const auto with =
      asked("Authorization: Bearer " + std::string(test::admin_token().text.text()) + "\r\n");
  EXPECT_THAT(with, StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(with, HasSubstr("feltwire_sessions{scene=\"room\"} 0\n"));

  test::RawSocket plain(SOCK_STREAM, port);
  const std::string question = "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  plain.send(bytes(question));
  std::string answer;
  for (auto part = plain.receive(); !part.empty(); part = plain.receive())
    answer.append(part.begin(), part.end());
  EXPECT_THAT(answer, ::testing::Not(HasSubstr("HTTP")));
}

/// The counters of the viewers are those of the page, at either port.
TEST(Operation, ThePortOfTheCountersHasThoseOfThePage) {
  ServerConfig config;
  config.port = 0;
  config.metrics = "0";
  config.web = "0";
  std::vector<Scene> scenes;
  scenes.push_back(test::room());
  Server server(config, std::move(scenes), test::security());
  const auto asked = [](const std::string& url, const std::string& question) {
    const std::string port = url.substr(url.rfind(':') + 1);
    test::RawSocket socket(SOCK_STREAM, static_cast<std::uint16_t>(std::stoi(port)));
    socket.send({reinterpret_cast<const std::uint8_t*>(question.data()), question.size()});
    std::string answer;
    for (auto part = socket.receive(); !part.empty(); part = socket.receive())
      answer.append(part.begin(), part.end());
    return answer;
  };
  EXPECT_THAT(asked(server.web_url(),
                    "GET /ticket?scene=room HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                    "Authorization: Bearer " +
                        std::string(test::admin_token().text.text()) + "\r\n\r\n"),
              StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(asked(server.metrics_url(), "GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"),
              HasSubstr("\nfeltwire_tickets_total 1\n"));
}

/// A configuration is checked with the files that it names, and without opening a port.
TEST(Operation, TheProgramChecksItsConfiguration) {
  const std::string file = path("checked.json");
  const auto check = [&](const std::string& json) {
    std::ofstream(file) << json;
    return test::Program(FELTWIRE_SERVER_PROGRAM, {"--config", file, "--check-config"}).finish();
  };
  const std::string scene = path("checked_scene.json");
  std::ofstream(scene) << R"({"name": "wall", "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})";
  const std::string state = path("checked_state");
  const std::string begin = "{\"scenes\": [\"" + scene + "\"], \"state\": \"" + state + "\"";
  const test::Outcome good = check(begin + ", \"port\": 0}");
  EXPECT_EQ(good.out, "the configuration is right, 1 scene(s)\n");
  EXPECT_EQ(good.status, 0) << good.error;
  EXPECT_THAT(check("{\"scenes\": [\"none.json\"]}").error, HasSubstr("none.json"));
  EXPECT_THAT(check(begin + ", \"tokens\": \"no_tokens.json\"}").error,
              HasSubstr("no_tokens.json"));
  EXPECT_THAT(check(begin + ", \"client_ca\": \"no_ca.pem\"}").error, HasSubstr("no_ca.pem"));
  EXPECT_THAT(check(begin + ",\n\"prot\": 0}").error, HasSubstr("checked.json:2: prot"));
  EXPECT_EQ(check(begin + ", \"join_rate\": 0}").status, 2);
  EXPECT_FALSE(std::filesystem::exists(state));
  const std::string junk = path("junk.pem");
  std::ofstream(junk) << "junk";
  EXPECT_THAT(check(begin + ", \"client_ca\": \"" + junk + "\"}").error,
              HasSubstr("junk.pem: holds no authority's certificate"));
  EXPECT_THAT(check("{\"scenes\": [\"" + scene + "\", \"" + scene + "\"]}").error,
              HasSubstr("two scenes are named 'wall'"));
  std::filesystem::create_directory(state);
  std::filesystem::permissions(state, std::filesystem::perms::owner_all);
  std::ofstream(state + "/tokens.json") << "junk";
  EXPECT_THAT(check(begin + "}").error, HasSubstr("checked_state/tokens.json:"));
  std::filesystem::remove_all(state);
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

/// Each line of a log in JSON must be one object with the text of the client as it is.
TEST(Operation, TheLogCanBeJson) {
  spdlog::memory_buf_t line;
  const std::string text = "hand \"a\"\n\x1b[31m \xff";
  json_log_format()->format({"program", spdlog::level::warn, text}, line);
  ASSERT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  const Json read = Json::parse(line.begin(), line.end());
  EXPECT_EQ(read.at("text"), "hand \"a\"\n\x1b[31m \xef\xbf\xbd");
  EXPECT_EQ(read.at("level"), "warning");
  EXPECT_EQ(read.at("program"), "program");
  EXPECT_THAT(read.at("time").get<std::string>(),
              ::testing::MatchesRegex("[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:]{8}[.][0-9]{6}Z"));
}

TEST(Operation, TheLogShowsNoToken) {
  const std::string token = "fw_0123456789ab_SHVXhD4MlOFA";
  for (const auto make : {visible_log_format, json_log_format}) {
    spdlog::memory_buf_t line;
    const std::string text = token + " (client anna) could not join scene '" + token + "'";
    make()->format({"program", spdlog::level::warn, text}, line);
    const std::string written(line.begin(), line.end());
    EXPECT_THAT(written,
                ::testing::AllOf(HasSubstr("fw_... (client anna) could not join scene 'fw_...'"),
                                 ::testing::Not(HasSubstr(token))));
  }
}

/// The program tells systemd when its ports are open.
TEST(Operation, TheServiceManagerLearnsOfTheStart) {
  const std::string place = path("notify");
  const int manager = ::socket(AF_UNIX, SOCK_DGRAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(place.size(), sizeof address.sun_path);
  std::copy(place.begin(), place.end(), address.sun_path);
  ::unlink(place.c_str());
  ASSERT_EQ(::bind(manager, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  const auto told = [&] {
    pollfd waiting{manager, POLLIN, 0};
    std::array<char, 64> text{};
    if (::poll(&waiting, 1, test::kPatience) != 1) return std::string();
    const auto size = ::recv(manager, text.data(), text.size(), 0);
    return std::string(text.data(), static_cast<std::size_t>(size));
  };
  const std::string scene = path("notified.json");
  std::ofstream(scene) << R"({"name": "wall", "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})";
  const Variable socket("NOTIFY_SOCKET", place);
  test::Program program(FELTWIRE_SERVER_PROGRAM, {"--scene", scene, "--port", "0"});
  EXPECT_EQ(told(), "READY=1");
  program.signal(SIGTERM);
  EXPECT_EQ(told(), "STOPPING=1");
  EXPECT_EQ(program.finish().status, 0);
  ::close(manager);
}

/// Seven descriptors are too few, and the remedy is no other folder.
TEST(Operation, TooManyOpenFilesHaveARemedy) {
  const std::string scene = path("scene.json");
  std::ofstream(scene) << R"({"name": "wall", "materials": [{"name": "wood", "stiffness": 1000}],
    "objects": [{"name": "floor", "plane": {}, "material": "wood"}]})";
  const test::Outcome outcome =
      test::Program("/bin/sh", {"-c", "ulimit -n 7; exec \"$@\"", "sh", FELTWIRE_SERVER_PROGRAM,
                                "--scene", scene, "--port", "0", "--state", path("few")})
          .finish();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.error, HasSubstr("Too many open files"));
  EXPECT_THAT(outcome.error, HasSubstr("; raise the limit of open files (ulimit -n)\n"));
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
