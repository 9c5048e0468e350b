// Tests feltwire-follower as a program: the selected robot, its files and its failures.

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/pending_file.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/program.hpp"

namespace feltwire::follower_program_test {
namespace {

using test::Outcome;
using test::Program;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::text_of;

const std::string kSource = FELTWIRE_SOURCE_DIR;
const std::string kTable = kSource + "/scenes/arm/table.xml";
const std::string kSurroundings = kSource + "/scenes/teleoperation/surroundings.json";

Scene seat_scene() {
  Scene scene = testing::floor_scene();
  scene.set_seats({RemoteSeat{}});
  return scene;
}

/// Returns a scene with two robots.
Scene pair_scene() {
  Scene scene("pair", testing::floor_scene().objects());
  scene.set_seats({RemoteSeat{.name = "left"}, RemoteSeat{.name = "right"}});
  return scene;
}

class FollowerProgram : public ::testing::Test {
 protected:
  FollowerProgram() {
    replace_file(folder_ / "token", robot_.text.text(), kPrivate);
    replace_file(folder_ / "paired", paired_.text.text(), kPrivate);
    replace_file(folder_ / "hand", hand_.text.text(), kPrivate);
    std::vector<Scene> scenes;
    scenes.push_back(seat_scene());
    scenes.push_back(pair_scene());
    server_ = std::make_unique<Server>(testing::any_ports(), std::move(scenes),
                                       test::security({robot_.token, paired_.token, hand_.token}));
  }
  std::vector<std::string> access(const char* token) {
    return {"--connect",     "127.0.0.1:" + std::to_string(server_->control_port()),
            "--token-file",  folder_ / token,
            "--fingerprint", to_string(server_->fingerprint())};
  }
  std::unique_ptr<Program> start(const std::vector<std::string>& more, const char* scene = "floor",
                                 const char* token = "token") {
    std::vector<std::string> words = access(token);
    words.insert(words.end(), {"--scene", scene});
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<Program>(FELTWIRE_FOLLOWER_PROGRAM, std::move(words));
  }
  /// Expects that the program does not start, and prints the reason in one line.
  void expect_end(int status, std::vector<std::string> arguments, const std::string& part) {
    // The option applies if the program starts.
    arguments.insert(arguments.end(), {"--duration", "0.2"});
    const Outcome outcome = start(std::move(arguments))->finish();
    EXPECT_EQ(outcome.status, status) << part;
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.error, AllOf(HasSubstr("feltwire-follower: "), HasSubstr(part)));
    EXPECT_EQ(std::ranges::count(outcome.error, '\n'), 1) << outcome.error;
  }
  /// An option or a configuration that is wrong.
  void expect_misuse(std::vector<std::string> arguments, const std::string& part) {
    expect_end(2, std::move(arguments), part);
  }
  /// A file, a server or a robot that cannot be used.
  void expect_fault(std::vector<std::string> arguments, const std::string& part) {
    expect_end(1, std::move(arguments), part);
  }
  /// Ends a running program after some samples.
  Outcome end(Program& program) {
    test::eventually("samples of the robot", [&] {
      const std::string rows = text_of(folder_ / "robot.csv");
      return std::ranges::count(rows, '\n') > 20;
    });
    program.signal(SIGINT);
    return program.finish();
  }
  nlohmann::json report() { return nlohmann::json::parse(text_of(folder_ / "robot.json")); }
  std::vector<std::string> written() {
    return {"--record", folder_ / "robot.csv", "--report", folder_ / "robot.json"};
  }

  testing::TemporaryFolder folder_;
  IssuedToken robot_ = issue_token("robot", "floor", Role::follower, std::nullopt);
  IssuedToken paired_ = issue_token("robot", "pair", Role::follower, std::nullopt);
  IssuedToken hand_ = issue_token("hand", "pair", Role::operator_, std::nullopt);
  std::unique_ptr<Server> server_;
};

TEST_F(FollowerProgram, WantsOneRobot) {
  expect_misuse({}, "no robot is given; give one of --surroundings FILE.json (a point), --arm");
  expect_misuse({"--arm", kTable, "--surroundings", kSurroundings}, "more than one robot is given");
  expect_misuse({"--arm", kTable, "--socket", folder_ / "driver"}, "more than one robot is given");
  expect_misuse({"--socket", folder_ / "driver", "--at", "0,0,0"}, "Leave out --at");
}

TEST_F(FollowerProgram, NamesAWorkspaceThatIsNone) {
  const auto with = [](const std::string& option, const std::string& value) {
    return std::vector<std::string>{"--surroundings", kSurroundings, option, value};
  };
  for (const char* box : {"0,0,0,1,1,0", "0,0,0,1,nan,1", "0,0,-2000,1,1,1"})
    expect_misuse(with("--workspace", box), "--workspace must be six numbers within 1000 m");
  for (const char* body : {"0,0,0,1,-1,0,0.1", "0,0,0,0,0,0,0.0001", "nan,0,0,0,0,0,0.1",
                           "0,0,0,0.1", "0,0,0,0,0,0,0.1,0", "0,0,0,0,0,0,0.1m", "a,0,0,0,0,0,0.1"})
    expect_misuse(with("--keep-out", body), "--keep-out must be seven numbers within 1000 m");
  std::vector<std::string> nine{"--surroundings", kSurroundings};
  for (int i = 0; i < 9; ++i) nine.insert(nine.end(), {"--keep-out", "-0.1,0,0,0,0,0,0.1"});
  expect_misuse(nine, "--keep-out is given 9 times; give it 8 times at most");
  expect_misuse(with("--lock", "x,w"), "--lock: there is no axis 'w'; give some of x, y, z");
}

TEST_F(FollowerProgram, ReadsOptionsFromAFile) {
  const auto config = [&](const std::string& json) {
    std::ofstream(folder_ / "robot.json") << json;
    return std::vector<std::string>{"--config", folder_ / "robot.json"};
  };
  const auto line = [&](int number, const std::string& says) {
    return (folder_ / "robot.json").string() + ":" + std::to_string(number) + ": " + says;
  };
  expect_misuse(config(R"({"keep_outs": ["0,0,0,1,-1,0,0.1"], "surroundings": ")" +
                       std::string(kSurroundings) + "\"}"),
                line(1, "keep_outs: --keep-out must be seven numbers"));
  expect_fault(config("{\n\"arm\": \"none.xml\"}"), (folder_ / "none.xml").string());
  expect_misuse(config("{\n\"leesh\": 5}"), line(2,
                                                 "leesh: is no option of this program; did you "
                                                 "mean leash?"));
  expect_misuse(config("{\n\"config\": \"a\"}"), line(2, "config: cannot be in a file"));
  // The command line decides which robot it is.
  std::vector<std::string> socket = config(R"({"arm": "none.xml"})");
  socket.insert(socket.end(), {"--socket", "/proc/nowhere/driver"});
  expect_fault(socket, "/proc/nowhere/driver");
  // A number of the file that CLI11 cannot read.
  const Outcome wrong = start(config("{\n\"leash\": \"strong\"}"))->finish();
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.error, HasSubstr(line(2, "leash: ")));

  std::vector<std::string> words =
      config(R"({"surroundings": ")" + std::string(kSurroundings) + R"(", "name": "of the file"})");
  const std::vector<std::string> more = {"--record", folder_ / "robot.csv", "--report",
                                         folder_ / "report.json"};
  words.insert(words.end(), more.begin(), more.end());
  const auto program = start(words);
  EXPECT_EQ(end(*program).status, 0);
  EXPECT_EQ(nlohmann::json::parse(text_of(folder_ / "report.json"))["name"], "of the file");
}

TEST_F(FollowerProgram, ATokenIsNeverPrinted) {
  const Outcome outcome = start({"--token=fw_0123456789ab_secret"})->finish();
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("fw_..."), Not(HasSubstr("0123456789ab"))));
}

TEST_F(FollowerProgram, ATokenThatOthersMayReadIsWarnedOfUnderItsOwnName) {
  std::filesystem::permissions(folder_ / "token", std::filesystem::perms(0644));
  const Outcome outcome = start({"--arm", "/proc/nowhere/arm.xml"})->finish();
  EXPECT_THAT(outcome.error, AllOf(HasSubstr("feltwire-follower: warning: --token-file"),
                                   Not(HasSubstr("feltwire-client"))));
}

TEST_F(FollowerProgram, NamesTheFileThatIsNoRobot) {
  expect_fault({"--arm", "/proc/nowhere/arm.xml"}, "/proc/nowhere/arm.xml");
  expect_fault({"--arm", kSurroundings}, kSurroundings);
  expect_fault({"--surroundings", kTable}, kTable);
  expect_fault({"--socket", "/proc/nowhere/driver"}, "/proc/nowhere/driver");
}

TEST_F(FollowerProgram, SaysWhereTheArmCannotBegin) {
  for (const char* at : {"2,0,0.3", "0.45,0,0.2"})
    expect_misuse({"--arm", kTable, "--at", at},
                  "--at " + std::string(at) + ": the arm of " + kTable + " comes only to ");
}

TEST_F(FollowerProgram, NamesTheFileThatItCannotWrite) {
  expect_fault({"--arm", kTable, "--record", "/proc/nowhere/robot.csv"}, "/proc/nowhere/robot.csv");
  expect_fault({"--arm", kTable, "--report", "/proc/nowhere/robot.json"},
               "/proc/nowhere/robot.json");
}

TEST_F(FollowerProgram, TheArmSitsOnTheSeatAndIsWrittenDown) {
  std::vector<std::string> words = written();
  words.insert(words.end(), {"--arm", kTable, "--at", "0.45,0,0.32"});
  const auto program = start(words);
  EXPECT_THAT(program->error_until("the robot's seat"), HasSubstr("the robot's seat"));
  const Outcome outcome = end(*program);
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("engaged 0 times"), HasSubstr("end: requested")));
  EXPECT_EQ(report()["robot"]["name"], "arm");
  EXPECT_EQ(report()["end"], "requested");
  EXPECT_EQ(report()["sessions"], 1);
  EXPECT_GT(report()["samples"], 20);
  ASSERT_EQ(report()["link"]["changes"].size(), 1u);
  EXPECT_EQ(report()["link"]["changes"][0]["state"], "disabled") << "no hand leads it";

  std::istringstream rows(text_of(folder_ / "robot.csv"));
  std::string row;
  std::getline(rows, row);
  EXPECT_EQ(row, "t,x,y,z,qw,qx,qy,qz,fx,fy,fz,cx,cy,cz,stiffness,sample,state");
  std::uint64_t count = 0;
  double before = -1.0;
  for (; std::getline(rows, row); ++count) {
    EXPECT_EQ(std::ranges::count(row, ','), 16) << row;
    EXPECT_TRUE(row.ends_with(",disabled")) << row;
    double t = 0.0, x = 0.0, y = 0.0, z = 0.0;
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf,%lf", &t, &x, &y, &z), 4) << row;
    EXPECT_GT(t, before);
    before = t;
    EXPECT_LE((Vec3(x, y, z) - Vec3(0.45, 0.0, 0.32)).norm(), 2e-3);
  }
  EXPECT_EQ(report()["samples"], count) << "a row for each sample";
}

/// The duration also counts while the program looks for its server.
TEST_F(FollowerProgram, ARunThatIsOverWithoutItsServerEndsAndSaysSo) {
  std::vector<std::string> words = {
      "--surroundings", kSurroundings, "--duration", "1", "--reconnect", "8"};
  for (const std::string& word : written()) words.push_back(word);
  const auto program = start(words);
  test::eventually("samples of the robot", [&] {
    const std::string rows = text_of(folder_ / "robot.csv");
    return std::ranges::count(rows, '\n') > 20;
  });
  server_->stop();
  const Outcome outcome = program->finish();
  EXPECT_EQ(outcome.status, 1) << outcome.error;
  EXPECT_THAT(outcome.out, HasSubstr("end: evicted"));
  constexpr int kInFiveSeconds = 5000;  // fewer than in the time to reconnect
  EXPECT_LT(report()["samples"], kInFiveSeconds);
}

TEST_F(FollowerProgram, ADriverInAnotherLanguageSitsOnTheSeat) {
  std::vector<std::string> words = written();
  words.insert(words.end(), {"--socket", folder_ / "driver"});
  const auto program = start(words);
  EXPECT_THAT(program->error_until("waits for a driver"), HasSubstr("waits for a driver"));
  const Program python("/usr/bin/env", {"python3", kSource + "/examples/my_follower.py",
                                        (folder_ / "driver").string()});
  EXPECT_THAT(program->error_until("the robot's seat"), HasSubstr("the robot's seat"));
  const Outcome outcome = end(*program);
  EXPECT_EQ(outcome.status, 0) << outcome.error;
  EXPECT_EQ(report()["robot"]["name"], "my_follower");
  EXPECT_EQ(report()["robot"]["servo_period_s"], 0.005);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "driver"));
}

/// The last line must not show a whole run if the robot went away in the middle.
TEST_F(FollowerProgram, ARobotThatIsGoneAtTheEndIsSaid) {
  std::vector<std::string> words = written();
  words.insert(words.end(), {"--socket", folder_ / "driver", "--duration", "3"});
  const auto program = start(words);
  EXPECT_THAT(program->error_until("waits for a driver"), HasSubstr("waits for a driver"));
  const Program python("/usr/bin/env", {"python3", kSource + "/examples/my_follower.py",
                                        (folder_ / "driver").string(), "1"});
  const Outcome outcome = program->finish();
  EXPECT_EQ(outcome.status, 1) << outcome.out;
  EXPECT_THAT(outcome.out, ::testing::ContainsRegex(
                               "end: requested; the robot failed at [0-9.]+ s: it gave no usable "
                               "state any more"));
}

TEST_F(FollowerProgram, OneHandMovesOneRobotAndThenAnother) {
  std::vector<std::unique_ptr<Program>> robots;
  for (const char* seat : {"left", "right"}) {
    robots.push_back(start({"--seat", seat, "--surroundings", kSurroundings, "--at", "0,0,0.05"},
                           "pair", "paired"));
    EXPECT_THAT(robots.back()->error_until("the robot's seat"), HasSubstr("the robot's seat"));
  }
  std::vector<std::string> words = access("hand");
  words.insert(words.end(), {"--scene", "pair", "--robot", "left", "--lead", "0.3", "--device",
                             "simulated:robot_button=1,press_button=1.5", "--duration", "3"});
  const Outcome hand = Program(FELTWIRE_CLIENT_PROGRAM, words).finish();
  EXPECT_EQ(hand.status, 0) << hand.error;
  for (const auto& robot : robots) {
    robot->signal(SIGINT);
    EXPECT_THAT(robot->finish().out, HasSubstr(", engaged 1 times"));
  }
}

}  // namespace
}  // namespace feltwire::follower_program_test
