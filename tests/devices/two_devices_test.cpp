// Tests two devices of one machine in one scene. Two programs run, each with its own board at a
// pseudo terminal.

#include <gmock/gmock.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/base/pending_file.hpp"
#include "protocol/net/clock.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/devices/hapi_stand_in.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/program.hpp"

namespace feltwire::two_devices_test {
namespace {

using stand_in::HapiBoard;
using test::Outcome;
using test::Program;

constexpr double kStill = 2.0;  // [s] rest of the hand at the start; the client waits for 0.1 s

/// Returns a wall with a normal towards the user. The masses of the boards tap there.
Scene wall_scene() {
  std::vector<Object> objects = testing::floor_scene().objects();
  objects.front().pose.orientation =
      Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()));
  return Scene("wall", objects);
}

struct TwoDevices : ::testing::Test {
  TwoDevices() {
    replace_file(folder / "token", hand.text.text(), kPrivate);
    std::vector<Scene> scenes;
    scenes.push_back(wall_scene());
    server = std::make_unique<Server>(testing::any_ports(), std::move(scenes),
                                      test::security({hand.token}));
  }
  std::unique_ptr<Program> start(const std::string& port, const std::string& name) {
    return std::make_unique<Program>(
        FELTWIRE_CLIENT_PROGRAM,
        std::vector<std::string>{
            "--connect", "127.0.0.1:" + std::to_string(server->control_port()), "--token-file",
            folder / "token", "--fingerprint", to_string(server->fingerprint()), "--scene", "wall",
            "--device", "hapi:" + port + ",damping=0.5,mass=0.1,await_still=0.1", "--duration",
            "300", "--hold-time", "1", "--report", folder / (name + ".json")});
  }

  testing::TemporaryFolder folder;
  IssuedToken hand = issue_token("hand", "wall", Role::operator_, std::nullopt);
  std::unique_ptr<Server> server;
};

TEST_F(TwoDevices, EachHandFeelsTheWallAndGetsNoEnergy) {
  std::array<HapiBoard, 2> boards;
  std::array<std::unique_ptr<Program>, 2> clients;
  const Nanoseconds began = monotonic_now();
  for (std::size_t i = 0; i < boards.size(); ++i) {
    boards[i].mass.waits = kStill;
    clients[i] = start(boards[i].port(), std::to_string(i));
  }
  for (HapiBoard& board : boards) {
    test::eventually("a force", [&] { return board.force > 0.2; });
    if (testing::measures())
      std::printf("a force %.2f s after the program's start\n", seconds(monotonic_now() - began));
  }
  for (std::size_t i = 0; i < boards.size(); ++i) {
    clients[i]->signal(SIGINT);
    const Outcome outcome = clients[i]->finish();
    EXPECT_EQ(outcome.status, 0) << outcome.error;
    EXPECT_EQ(boards[i].force, 0.0);  // No force may remain on the hand.
    boards[i].stop();
    EXPECT_LE(boards[i].mass.most_made, 1e-12);
    const auto report =
        nlohmann::json::parse(testing::text_of(folder / (std::to_string(i) + ".json")));
    EXPECT_GT(report["samples"], 1000);
  }
}

/// Two programs open one board. The second must get an error, and the first must continue.
TEST_F(TwoDevices, ABoardThatIsInUseIsRefused) {
  HapiBoard board;
  board.mass.waits = kStill;
  const std::unique_ptr<Program> first = start(board.port(), "first");
  test::eventually("a force", [&] { return board.force > 0.2; });
  const Outcome second = start(board.port(), "second")->finish();
  EXPECT_EQ(second.status, 1);
  EXPECT_THAT(second.error, ::testing::HasSubstr("another program holds it"));
  first->signal(SIGINT);
  EXPECT_EQ(first->finish().status, 0);
}

TEST_F(TwoDevices, IdentifyTakesNoFirmwareForABoard) {
  Program identify(FELTWIRE_CLIENT_PROGRAM,
                   {"identify", "--device", "hapi:/dev/none,firmware=image.bin"});
  const Outcome outcome = identify.finish();
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.error, ::testing::HasSubstr("firmware of --device is for falcon"));
}

/// A command that runs no session uses no setting but the plant and the firmware.
TEST_F(TwoDevices, IdentifyAndDevicesNameTheSettingThatTheyDoNotUse) {
  const auto refused = [](const std::vector<std::string>& words) {
    const Outcome outcome = Program(FELTWIRE_CLIENT_PROGRAM, words).finish();
    EXPECT_EQ(outcome.status, 2);
    return outcome.error;
  };
  EXPECT_THAT(refused({"identify", "--device", "hapi:/dev/none,map_scale=2"}),
              ::testing::HasSubstr("map_scale has no effect in this command; leave it out"));
  EXPECT_THAT(refused({"devices", "--rate", "hapi:/dev/none,map_scale=2"}),
              ::testing::HasSubstr("map_scale has no effect in this command; leave it out"));
  EXPECT_THAT(refused({"identify", "--device", "falcon", "--firmware", "image.bin"}),
              ::testing::HasSubstr("--firmware is an old spelling; write --device falcon:"));
  EXPECT_THAT(refused({"devices", "--rate", "falcon", "--firmware", "image.bin"}),
              ::testing::HasSubstr("--firmware is an old spelling; write --rate falcon:"));
}

}  // namespace
}  // namespace feltwire::two_devices_test
