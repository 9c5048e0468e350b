// feltwire-server as a user meets it.

#include "tests/support/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "server/server.hpp"
#include "tests/server/make.hpp"

namespace feltwire {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using test::Outcome;

struct Program : test::Program {
  explicit Program(std::vector<std::string> arguments)
      : test::Program(FELTWIRE_SERVER_PROGRAM, std::move(arguments)) {}
};

std::string write_file(const std::string& name, const std::string& content) {
  const std::string path = testing::TempDir() + "feltwire_" + std::to_string(::getpid()) + name;
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
    EXPECT_THAT(program.line(),
                testing::MatchesRegex("listening: control tcp [0-9]+, scene wall udp [0-9]+"));
    program.signal(ending);
    const Outcome outcome = program.finish();
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.out, HasSubstr("scene wall: sessions 0"));
  }
}

TEST(Program, CommandLineWinsOverTheFile) {
  scene_file();
  const std::string config = write_file(
      "server.json", R"({"scenes": [")" + scene_file() + R"("], "port": 70, "log_level": "off"})");
  Program program({"--config", config, "--port", "0"});
  EXPECT_THAT(program.line(), StartsWith("listening: control tcp "));
  program.signal(SIGTERM);
  const Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.error, "");  // the file's log level was kept
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
  const Server server(config, std::move(scenes));
  const std::string port = std::to_string(server.control_port());
  expect_one_line(Program({"--scene", scene_file(), "--port", port}).finish(), port);
}

TEST(Program, HelpHasExamples) {
  const Outcome outcome = Program({"--help"}).finish();
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("--silence-timeout"), HasSubstr("Examples")));
}

}  // namespace
}  // namespace feltwire
