// Tests feltwire-client with each driver and its maker's substitute, in the demo room of
// feltwire-server. The two programs use UDP.

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/devices/hapi_stand_in.hpp"
#include "tests/devices/haply_stand_in.hpp"
#include "tests/devices/shared_page.hpp"
#include "tests/devices/stand_in_session.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::driver_program_test {
namespace {

using stand_in::HapiBoard;
using stand_in::HaplyService;
using stand_in::NewPage;
using test::becomes;
using test::Outcome;
using test::Program;
using ::testing::HasSubstr;
using Words = std::vector<std::string>;

constexpr double kStill = 1.0;  // [s] rest of the hand at the start; the client waits for 0.1 s
constexpr double kFelt = 0.2;   // [N]

/// A substitute of a maker's library for the test, in this program or in the client's.
struct StandIn {
  std::string device;  // argument of --device
  Words options;       // numbers of the substitute's mass, and the pose of the device in the room
  std::function<double()> made;  // [J] excess energy of the true motion, after the session
  std::function<double()> force, largest_force;  // [N]
  std::function<long()> ticks;
  double slowest;               // [s] longest possible period of the session
  std::shared_ptr<void> owner;  // owner of the data that the functions use
};

/// The top of the table is at z = -0.05. A hand taps along the z axis of its device.
const std::string kOnTheTable = "map_translate=0,0,-0.05";
const std::string kTrueMass = ",damping=0.5,mass=0.1";

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// During its life, sets the places of the substitutes for makers' libraries and USB.
struct Places {
  explicit Places(const std::string& usb) {
    ::setenv("FELTWIRE_STAND_IN_USB", usb.c_str(), 1);
    ::setenv("FDSDK", FELTWIRE_FDSDK, 1);
    ::setenv("OH_SDK_BASE", FELTWIRE_OH_SDK, 1);
    ::setenv("LD_LIBRARY_PATH", FELTWIRE_USB, 1);
  }
  ~Places() {
    for (const char* name : {"FDSDK", "OH_SDK_BASE", "LD_LIBRARY_PATH", "FELTWIRE_STAND_IN_USB"})
      ::unsetenv(name);
  }
  Places(const Places&) = delete;
  Places& operator=(const Places&) = delete;
};

/// Returns a specification with the mass of the substitutes. Some drivers' own specifications
/// assume a larger mass.
std::string true_spec(const test::TemporaryFolder& folder) {
  std::string file = folder / "mass.json";
  std::ofstream(file) << R"({"name": "mass", "damping": [0.5], "apparent_mass": 0.1,
    "least_mass": 0.1, "least_friction": 0.05, "position_resolution": 20e-6, "max_force": 6.0,
    "workspace": [0.2, 0.2, 0.1]})";
  return file;
}

/// Returns the substitute of a library that the client loads.
StandIn loaded(const test::TemporaryFolder& folder, const std::string& device, Words options,
               double slowest) {
  const auto page = std::make_shared<NewPage>(folder / (device.substr(0, 6) + ".page"));
  (*page)->waits.store(kStill);
  return {.device = device + (device.find(':') == std::string::npos ? ":" : ",") + kOnTheTable,
          .options = std::move(options),
          .made = [page] { return (*page)->made.load(); },
          .force = [page] { return (*page)->force.load(); },
          .largest_force = [page] { return (*page)->largest_force.load(); },
          .ticks = [page] { return (*page)->ticks.load(); },
          .slowest = slowest,
          .owner = page};
}

StandIn force_dimension(const test::TemporaryFolder& folder) {
  return loaded(folder, "forcedimension", {"--spec", true_spec(folder)}, 1e-3);
}
StandIn open_haptics(const test::TemporaryFolder& folder) {
  return loaded(folder, "openhaptics", {"--spec", true_spec(folder)}, 1.25e-3);
}
StandIn falcon(const test::TemporaryFolder& folder) {
  StandIn all = loaded(folder, "falcon", {}, 0.05);
  all.device += kTrueMass;
  return all;
}
StandIn plugin(const test::TemporaryFolder& folder) {
  return loaded(folder, "plugin:" FELTWIRE_PLUGIN_STAND_IN, {}, 1e-3);
}

/// Returns the substitute of a board or a service in this program.
template <class Stand>
StandIn standing(std::shared_ptr<Stand> stand, const std::string& device, std::atomic<int>& ticks) {
  stand->mass.waits = kStill;
  return {.device = device + kTrueMass,
          .options = {},
          .made = [stand] { return stand->stop(), stand->mass.most_made; },
          .force = [stand] { return stand->force.load(); },
          .largest_force = [stand] { return stand->stop(), stand->mass.largest_force; },
          .ticks = [&ticks] { return long{ticks}; },
          .slowest = 0.05,
          .owner = stand};
}

template <HaplyService::Json json>
StandIn haply(const test::TemporaryFolder&) {
  const auto service = std::make_shared<HaplyService>(json);
  return standing(service, "haply:@" + std::to_string(service->port()) + "," + kOnTheTable,
                  service->commands);
}

/// The board taps along its y axis, which is the x axis of the driver.
StandIn hapi(const test::TemporaryFolder&) {
  const auto board = std::make_shared<HapiBoard>();
  return standing(board, "hapi:" + board->port() + "," + kOnTheTable + ",map_rotate=0,-90,0",
                  board->frames);
}

/// The server and the room of the demo.
struct Room {
  Room()
      : server(FELTWIRE_SERVER_PROGRAM, {"--scene", FELTWIRE_SOURCE_DIR "/scenes/room.json",
                                         "--port", "0", "--state", folder / "state"}) {
    server.line();  // This line has the fingerprint.
    const std::string listening = server.line();
    if (std::sscanf(listening.c_str(), "listening: control tcp %u", &port) != 1)
      throw std::runtime_error("no server: " + server.finish().error);
  }
  Words client(const std::string& device, const Words& options, const std::string& report) const {
    return Words{"--connect", "127.0.0.1:" + std::to_string(port), "--token-file",
                 folder / "state/local.token", "--fingerprint-file", folder / "state/fingerprint",
                 "--scene", "room", "--device", device + ",await_still=0.1",
                 // On a busy machine ticks are late, which is no fault here.
                 "--hold-time", "1", "--report", report} +
           options;
  }

  test::TemporaryFolder folder;
  Places places{folder / ""};
  Program server;
  unsigned port = 0;
};

nlohmann::json report_in(const std::string& file) {
  std::ifstream text(file);
  return nlohmann::json::parse(text);
}

struct Kind {
  const char* name;
  StandIn (*make)(const test::TemporaryFolder& folder);
};

struct DriverProgram : ::testing::TestWithParam<Kind> {
  Room room;
};

TEST_P(DriverProgram, FeelsTheRoomAtItsOwnTicksAndMakesNoEnergy) {
  const StandIn stand = GetParam().make(room.folder);
  const std::string file = room.folder / "report.json";
  Program client(FELTWIRE_CLIENT_PROGRAM, room.client(stand.device, stand.options, file));
  const double lasts = testing::session_seconds(kStill + 1.0);
  bool felt = false;
  becomes(
      [&] {
        felt = stand.force() > kFelt && 1e-3 * static_cast<double>(stand.ticks()) > lasts;
        return felt || client.ended();
      },
      test::kLongest + 4 * std::chrono::seconds(std::lround(lasts)));
  // Threads of the driver or of the maker's library may also get the signals.
  client.signal(SIGUSR1);
  const std::string asked = client.error_until("asked for");
  client.signal(SIGINT);
  const Outcome outcome = client.finish();
  ASSERT_TRUE(felt) << outcome.out << asked << outcome.error;
  ASSERT_EQ(outcome.status, 0) << asked << outcome.error;

  EXPECT_EQ(stand.force(), 0.0);  // No force may remain on the hand.
  EXPECT_LE(stand.made(), 1e-12);
  const nlohmann::json report = report_in(file);
  // The report names the device without its settings.
  EXPECT_THAT(stand.device, ::testing::StartsWith(report["device"]["kind"].get<std::string>()));
  EXPECT_EQ(report["end"], "requested");
  EXPECT_GE(report["flight_records"].size(), 1u) << asked;
  EXPECT_GT(report["max_force_n"], kFelt);
  EXPECT_LE(report["bound_violations"], 0);
  EXPECT_EQ(report["disconnections"], 0);
  // On a busy machine a service or a board is sometimes late. Such ticks are overruns.
  EXPECT_LE(report["device_faults"], report["overruns"]) << outcome.error;
  // Each sample must be a tick of the device.
  EXPECT_GE(report["parameters"]["servo_period_s"], 1e-3);
  EXPECT_LE(report["parameters"]["servo_period_s"], stand.slowest);
  EXPECT_LE(report["samples"], stand.ticks());
  EXPECT_GT(report["samples"], 500);
  if (testing::measures())
    std::printf(
        "%-16s %6.1f s %8ld ticks %8ld samples %5ld late %4ld overruns %4ld faults "
        "%6.2f N %10.2e J made\n",
        GetParam().name, report["duration_s"].get<double>(), stand.ticks(),
        report["samples"].get<long>(), report["missed_deadlines"].get<long>(),
        report["overruns"].get<long>(), report["device_faults"].get<long>(), stand.largest_force(),
        stand.made());
}

INSTANTIATE_TEST_SUITE_P(Drivers, DriverProgram,
                         ::testing::Values(Kind{"forcedimension", force_dimension},
                                           Kind{"openhaptics", open_haptics},
                                           Kind{"haply_3_1", haply<HaplyService::Json::v3_1>},
                                           Kind{"haply_3_5", haply<HaplyService::Json::v3_5>},
                                           Kind{"falcon", falcon}, Kind{"hapi", hapi},
                                           Kind{"plugin", plugin}),
                         [](const auto& kind) { return std::string(kind.param.name); });

/// A machine has two Falcons. Two programs must each get their own, and a third program none.
TEST(FalconPrograms, EachHasTheOneOfItsNumber) {
  const Room room;
  std::array<std::unique_ptr<NewPage>, 2> pages;
  std::array<std::unique_ptr<Program>, 2> clients;
  const auto client_of = [&](int number, const std::string& report) {
    return std::make_unique<Program>(
        FELTWIRE_CLIENT_PROGRAM,
        room.client("falcon:" + std::to_string(number) + "," + kOnTheTable + kTrueMass, {},
                    room.folder / report));
  };
  for (const int n : {0, 1}) {
    const std::string name = std::to_string(n);
    pages[n] = std::make_unique<NewPage>(room.folder / (name + ".page"));
    (*pages[n])->waits.store(kStill);
    (*pages[n])->devices.store(2);
    clients[n] = client_of(n, name + ".json");
  }
  for (const auto& page : pages)
    test::eventually("a force", [&] { return (*page)->force.load() > kFelt; });
  EXPECT_EQ((*pages[0])->number, 0);
  EXPECT_EQ((*pages[1])->number, 1);
  {
    NewPage page(room.folder / "third.page");
    page->devices.store(2);
    const Outcome taken = client_of(1, "third.json")->finish();
    EXPECT_EQ(taken.status, 1);
    EXPECT_THAT(taken.error, HasSubstr("falcon: another program has it"));
    const Outcome missing = client_of(2, "third.json")->finish();
    EXPECT_EQ(missing.status, 1);
    EXPECT_THAT(missing.error, HasSubstr("there are only 2 of them, counted from 0"));
  }
  for (const int n : {0, 1}) {
    clients[n]->signal(SIGINT);
    const Outcome outcome = clients[n]->finish();
    EXPECT_EQ(outcome.status, 0) << outcome.error;
    EXPECT_EQ((*pages[n])->force, 0.0);
    EXPECT_LE((*pages[n])->made, 1e-12);
    EXPECT_GT(report_in(room.folder / (std::to_string(n) + ".json"))["samples"], 500);
  }
}

/// A script detects the result of a run by its exit status and its last line.
TEST(DeviceTrouble, ARunWhoseDeviceFailsEndsWithAnErrorThatSaysSo) {
  for (const bool holds_nothing : {false, true}) {
    const Room room;
    NewPage page(room.folder / "plugin.page");
    page->waits.store(kStill);
    const std::string file = room.folder / "report.json";
    Program client(FELTWIRE_CLIENT_PROGRAM,
                   room.client("plugin:" FELTWIRE_PLUGIN_STAND_IN "," + kOnTheTable, {}, file));
    test::eventually("a force", [&] { return page->force.load() > kFelt; });
    (holds_nothing ? page->refuses : page->unplugged).store(true);
    const char* const says =
        holds_nothing ? "no force: the device does not hold" : "no force: the device gives no";
    std::string told = client.error_until(says);
    told += client.error_until(says);  // The message comes a second later.
    client.signal(SIGINT);
    const Outcome outcome = client.finish();
    EXPECT_EQ(outcome.status, 1) << told << outcome.error;
    EXPECT_THAT(outcome.out, HasSubstr("; the device failed at "));
    EXPECT_THAT(outcome.error, HasSubstr("feltwire-client: the device failed at "));
    EXPECT_FALSE(report_in(file)["device_trouble"].is_null());
    if (!holds_nothing) {
      EXPECT_THAT(outcome.out, HasSubstr(" device fault"));
    }
  }
}

/// The device's ticks are late, and nothing else reports the cause.
TEST(DeviceTrouble, ADeviceThatIsSlowIsNamed) {
  const Room room;
  NewPage page(room.folder / "plugin.page");
  page->slow_read.store(20);
  const std::string file = room.folder / "report.json";
  Program client(FELTWIRE_CLIENT_PROGRAM,
                 room.client("plugin:" FELTWIRE_PLUGIN_STAND_IN "," + kOnTheTable, {}, file));
  const std::string told = client.error_until("the device is slow: its calls took ");
  client.signal(SIGINT);
  const Outcome outcome = client.finish();
  EXPECT_EQ(outcome.status, 0) << told << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("warning: the device's read() takes "));
  const nlohmann::json report = report_in(file);
  EXPECT_GT(report["device_read_us"]["p50"], 15000.0);  // 20 ms, rounded by the histogram
  EXPECT_GT(report["device_slow_ticks"], 0);
  EXPECT_THAT(report["device_slow"].get<std::string>(), HasSubstr("read()"));
}

/// The tool must rest while the chosen button is pressed, but not while the driver's own button is
/// pressed.
TEST(Buttons, TheChosenOneIsTheClutch) {
  const Room room;
  NewPage page(room.folder / "plugin.page");
  const std::string file = room.folder / "report.json";
  Program client(FELTWIRE_CLIENT_PROGRAM,
                 room.client("plugin:" FELTWIRE_PLUGIN_STAND_IN "," + kOnTheTable +
                                 ",clutch_button=3,deadman_button=4",
                             {}, file));
  test::eventually("a force", [&] { return page->force.load() > kFelt; });
  page->buttons.store(1U << 1U);  // the default clutch of the driver
  const long pressed = page->ticks;
  test::eventually("a force",
                   [&] { return page->ticks > pressed + 100 && page->force.load() > kFelt; });
  page->buttons.store(1U << 2U);
  const long chosen = page->ticks;
  // A second has more than one tap.
  test::eventually("it ticks", [&] { return page->ticks > chosen + 1000; });
  EXPECT_EQ(page->force, 0.0);
  client.signal(SIGINT);
  EXPECT_EQ(client.finish().status, 0);
  EXPECT_GT(report_in(file)["no_force"]["samples"]["clutched"], 500);
}

}  // namespace
}  // namespace feltwire::driver_program_test
