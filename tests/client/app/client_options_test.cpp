#include "client/app/client_options.hpp"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "client/app/add_options.hpp"
#include "core/device/spec_names.hpp"
#include "protocol/session/profiles.hpp"
#include "tests/client/app/parsed_options.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/support/help.hpp"

namespace feltwire::options_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::text_of;

TEST(Options, AHandIsProtectedAsFarAsItsModeAllows) {
  const SafetyLimits usual = limits({});
  EXPECT_EQ(usual.force.small, 0.05);
  EXPECT_EQ(usual.force.speed, 1.5);
  // A bound already limits the force. A ramp would only delay the user's contact.
  EXPECT_EQ(usual.ramp_up, 0.0);
  EXPECT_TRUE(std::isinf(usual.force.slew));
  EXPECT_TRUE(std::isinf(usual.force.max));
  EXPECT_EQ(limits({"--mode", "none"}).ramp_up, 0.2);
  EXPECT_EQ(limits({"--mode", "side=server"}).ramp_up, 0.2);
  const SafetyLimits paper = limits({"--mode", "per_axis"});
  EXPECT_EQ(paper.force.small, 0.05);
  EXPECT_TRUE(std::isinf(paper.force.speed));
  EXPECT_EQ(paper.ramp_up, 0.0);
}

TEST(Options, TheWorkspaceIsMapped) {
  const auto options = parsed(
      {"--device", "simulated:map_scale=2,map_rotate=0,0,90,map_translate=0.1,0,0,map_mirror=y"});
  ASSERT_TRUE(std::holds_alternative<ClientOptions>(options));
  const WorkspaceMapping& mapping = std::get<ClientOptions>(options).mapping;
  EXPECT_EQ(mapping.scale, 2.0);
  EXPECT_EQ(mapping.translation, Vec3(0.1, 0, 0));
  EXPECT_EQ(mapping.axes() * Vec3(1, 2, 3), Vec3(2, 1, 3));
  EXPECT_THAT(refusal({"--device", "simulated:map_scale=0"}), HasSubstr("from 0.01 to 100"));
  EXPECT_THAT(refusal({"--device", "simulated:map_rotate=nan,0,0"}), HasSubstr("at most 360"));
  EXPECT_THAT(refusal({"--device", "simulated:map_translate=0,inf,0"}), HasSubstr("within 100 m"));
  for (const char* axis : {"w", "xy"})
    EXPECT_THAT(refusal({"--device", std::string("simulated:map_mirror=") + axis}),
                HasSubstr("must be x, y or z"));
}

TEST(Options, AGamepadIsSteeredByTheNumbersOfItsOptions) {
  const auto options =
      parsed({"--device", "gamepad:event5,steer_speed=0.05,steer_turn=0.4,dead_zone=0.2"});
  ASSERT_TRUE(std::holds_alternative<ClientOptions>(options));
  const DeviceRequest& asked = std::get<ClientOptions>(options).device;
  EXPECT_EQ(asked.name, "event5");
  EXPECT_EQ(asked.steering.speed, 0.05);
  EXPECT_EQ(asked.steering.turn, 0.4);
  EXPECT_EQ(asked.steering.dead_zone, 0.2);
  EXPECT_THAT(refusal({"--device", "gamepad:steer_speed=0"}), HasSubstr("0.1 is usual"));
  EXPECT_THAT(refusal({"--device", "gamepad:steer_turn=nan"}),
              HasSubstr("steer_turn of --device must be above 0"));
  EXPECT_THAT(refusal({"--device", "gamepad:dead_zone=0.6"}), HasSubstr("from 0 to 0.5"));
}

TEST(Options, ALocalModelIsForASideThatBoundsHere) {
  const auto options = parsed({"--local-model", "whole"});
  ASSERT_TRUE(std::holds_alternative<ClientOptions>(options));
  EXPECT_TRUE(std::get<ClientOptions>(options).parameters.local_model);
  EXPECT_FALSE(std::get<ClientOptions>(parsed({"--mode", "contact_frame"})).parameters.local_model);
  EXPECT_THAT(refusal({"--local-model", "whole", "--mode", "side=server"}),
              HasSubstr("local_model"));
  EXPECT_TRUE(std::get<ClientOptions>(options).whole_surfaces);
  const auto patches = std::get<ClientOptions>(parsed({"--local-model", "patches"}));
  EXPECT_TRUE(patches.parameters.local_model);
  EXPECT_FALSE(patches.whole_surfaces);
  // The word behind the option is its value.
  EXPECT_THAT(refusal({"--local-model", "--mode", "none"}),
              HasSubstr("--local-model: '--mode' is none of off, patches, whole"));
}

TEST(Options, WhatIsNotSaidOfTheBoundFollowsFromTheRest) {
  const auto asked = [](const std::vector<std::string>& words) {
    return std::get<ClientOptions>(parsed(words)).parameters;
  };
  EXPECT_EQ(asked({}), usual_parameters());
  EXPECT_EQ(asked({}).mode, "shaped");
  EXPECT_FALSE(asked({"--local-model", "off"}).local_model);
  EXPECT_EQ(asked({"--local-model", "off"}).mode, "shaped");
  for (const char* side : {"side=server", "side=both"}) {
    EXPECT_EQ(asked({"--mode", side}).mode, "contact_frame");
    EXPECT_FALSE(asked({"--mode", side}).local_model);
  }
  EXPECT_TRUE(asked({"--mode", "credited"}).local_model);
  EXPECT_TRUE(asked({"--mode", "contact_frame", "--traffic", "wan"}).local_model);
  EXPECT_EQ(asked({"--mode", "virtual_coupling"}).side, BoundingSide::server);
  EXPECT_THAT(refusal({"--mode", "shaped,side=server"}), HasSubstr("at the client"));
}

TEST(Options, AHandMayAskForATool) {
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--tool", "key"})).tool, "key");
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--tool", "key", "--traffic", "wan"})).tool, "key");
  EXPECT_EQ(std::get<ClientOptions>(parsed({})).tool, "");
}

TEST(Options, WhatTheCommandLineSaysCounts) {
  const SafetyLimits said = limits({"--slew", "500", "--ramp-up", "0.3", "--wait-for-small-force",
                                    "0.2", "--max-force", "2", "--velocity-limit", "0.8"});
  EXPECT_EQ(said.force.slew, 500.0);
  EXPECT_EQ(said.ramp_up, 0.3);
  EXPECT_EQ(said.force.small, 0.2);
  EXPECT_EQ(said.force.max, 2.0);
  EXPECT_EQ(said.force.speed, 0.8);
  const SafetyLimits off = limits({"--mode", "none", "--ramp-up", "0", "--wait-for-small-force",
                                   "inf", "--velocity-limit", "inf"});
  EXPECT_TRUE(std::isinf(off.force.small) && std::isinf(off.torque.small));
  EXPECT_TRUE(std::isinf(off.force.speed));
  EXPECT_EQ(off.ramp_up, 0.0);
  const auto hand = std::get<ClientOptions>(parsed({"--device", "simulated:lead_in=3"}));
  EXPECT_EQ(hand.device.task.lead_in, 3.0);
}

TEST(Options, ARobotIsBelievedAsFarAsItsUserSays) {
  const auto leads = [](const std::vector<std::string>& words) {
    return std::get<ClientOptions>(parsed(words)).servo.leads;
  };
  EXPECT_FALSE(leads({}));
  EXPECT_EQ(leads({"--lead", "0.3"})->per_contact, 0.0);
  EXPECT_EQ(leads({"--lead", "0.3"})->power, 0.0);
  const auto trusting = leads({"--lead", "0.3", "--trust-robot", "0.1,5"});
  EXPECT_EQ(trusting->per_contact, 0.1);
  EXPECT_EQ(trusting->power, 5.0);
  EXPECT_THAT(refusal({"--trust-robot", "0.1,5"}), HasSubstr("add --lead"));
  for (const char* wrong : {"-0.1,5", "2,5", "0.1,60", "nan,5"})
    EXPECT_THAT(refusal({"--lead", "0.3", "--trust-robot", wrong}), HasSubstr("0 to 1 J"));
}

TEST(Options, AHandChoosesItsRobot) {
  const auto options =
      std::get<ClientOptions>(parsed({"--lead", "0.3", "--robot", "left", "--device", "gamepad"}));
  EXPECT_EQ(options.robot, "left");
  EXPECT_EQ(options.servo.seat_button, 0);
  EXPECT_THAT(refusal({"--robot", "left"}), HasSubstr("--robot is for a hand with --lead"));
  EXPECT_THAT(refusal({"--device", "simulated:robot_button=1"}),
              HasSubstr("robot_button of --device is for a hand with"));
  EXPECT_THAT(refusal({"--lead", "0.3", "--device", "hapi:/dev/ttyACM0,robot_button=1"}),
              HasSubstr("robot_button: of --device hapi no button is read"));
  EXPECT_EQ(std::get<ClientOptions>(
                parsed({"--device", "simulated:robot_button=1,press_button=2", "--lead", "0.3"}))
                .device.presses_at,
            2.0);
  for (const std::vector<std::string>& wrong : {
           std::vector<std::string>{"--device", "simulated:press_button=-1"},
           {"--device", "simulated:press_button=inf"},
       })
    EXPECT_THAT(refusal(wrong), HasSubstr("press_button of --device simulated is a time of 0"));
  EXPECT_THAT(refusal({"--device", "gamepad:press_button=2"}),
              HasSubstr("--device: press_button is for a simulated hand; leave it out"));
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--lead", "0.3", "--device", "falcon:robot_button=2"}))
                .servo.seat_button,
            2);
  EXPECT_THAT(refusal({"--lead", "0.3", "--device", "falcon:robot_button=99"}),
              HasSubstr("robot_button: of --device falcon the buttons 1 to "));
}

TEST(Options, TheEnablingSwitchAndTheClutchAreButtonsThatTheUserChooses) {
  const auto chosen = [](const std::vector<std::string>& words) {
    return std::get<ClientOptions>(parsed(words)).protection;
  };
  const ProtectionOptions usual = chosen({"--device", "falcon"});
  EXPECT_EQ(usual.deadman_button, std::nullopt);
  EXPECT_EQ(usual.clutch_button, std::nullopt);
  const ProtectionOptions both = chosen({"--device", "falcon:deadman_button=4,clutch_button=3"});
  EXPECT_EQ(both.deadman_button, 4);
  EXPECT_EQ(both.clutch_button, 3);
  // The other button keeps the driver's default.
  EXPECT_EQ(chosen({"--device", "falcon:clutch_button=3"}).deadman_button, std::nullopt);
  EXPECT_EQ(chosen({"--device", "forcedimension:clutch_button=0"}).clutch_button, 0);
  EXPECT_EQ(chosen({"--device", "forcedimension:deadman_button=1,clutch_button=2"}).deadman_button,
            1);
}

TEST(Options, AButtonHasOneMeaning) {
  EXPECT_THAT(refusal({"--device", "openhaptics:clutch_button=5"}),
              HasSubstr("clutch_button: of --device openhaptics the buttons 1 to 4 are read"));
  EXPECT_THAT(refusal({"--device", "falcon:deadman_button=-1"}),
              HasSubstr("deadman_button: of --device falcon the buttons 1 to 4 are read"));
  EXPECT_THAT(refusal({"--device", "hapi:/dev/ttyACM0,deadman_button=1"}),
              HasSubstr("deadman_button: of --device hapi no button is read"));
  const auto two_meanings = HasSubstr(
      "would be the enabling switch and the clutch; give deadman_button and "
      "clutch_button, each its own, or 0 for none");
  EXPECT_THAT(refusal({"--device", "falcon:deadman_button=3,clutch_button=3"}), two_meanings);
  EXPECT_THAT(refusal({"--device", "forcedimension:deadman_button=1"}), two_meanings);
  EXPECT_THAT(refusal({"--device", "haply:clutch_button=1"}), two_meanings);
  EXPECT_THAT(refusal({"--device", "falcon:clutch_button=3,emergency_button=3"}),
              HasSubstr("clutch_button and emergency_button of --device are the same button"));
  EXPECT_THAT(refusal({"--lead", "0.3", "--device", "falcon:deadman_button=3,robot_button=3"}),
              HasSubstr("deadman_button and robot_button of --device are the same button"));
}

TEST(Options, LimitsThatCannotBeAreRefusedInOneLine) {
  EXPECT_THAT(refusal({"--mode", "per_axis", "--velocity-limit", "1"}),
              HasSubstr("velocity limit of 1 m/s cannot follow the bounding mode per_axis"));
  EXPECT_THAT(refusal({"--mode", "total_energy", "--ramp-up", "0.1"}), HasSubstr("ramp-up"));
  EXPECT_THAT(refusal({"--max-force", "-1"}), HasSubstr("force.max = -1"));
  EXPECT_THAT(refusal({"--mode", "account=off"}),
              HasSubstr("the mode shaped is passive by the account alone"));
  EXPECT_THAT(refusal({"--mode", "per_axis,account=off,side=server"}),
              HasSubstr("of the mode per_axis of a bound at the server is passive by the account"));
  EXPECT_THAT(refusal({"--ramp-up", "nan"}), HasSubstr("ramp_up"));
}

SessionParameters asked(const std::vector<std::string>& words) {
  const auto options = parsed(words);
  if (const int* code = std::get_if<int>(&options)) {
    ADD_FAILURE() << "refused with " << *code;
    return {};
  }
  return std::get<ClientOptions>(options).parameters;
}

/// The names may be equal paths, hard links or symbolic links. The file may exist or not.
TEST(Options, NoFileIsWrittenTwiceNorOverWhatIsRead) {
  const testing::TemporaryFolder folder;
  const auto path = [&](const char* name) { return (folder / name).string(); };
  for (const char* there : {"a", "hand.csv"}) std::ofstream(folder / there) << "text";
  std::filesystem::create_hard_link(folder / "a", folder / "hard");
  std::filesystem::create_symlink("a", folder / "soft");
  std::filesystem::create_symlink("later", folder / "dangling");
  std::filesystem::create_directory(folder / "sub");
  std::filesystem::create_directory_symlink(folder / "sub", folder / "other");
  using Pair = std::pair<std::string, std::string>;
  for (const auto& [record, report] :
       {Pair{path("new"), path("new")}, Pair{path("new"), path("sub/../new")},
        Pair{path("sub/new"), path("other/new")}, Pair{path("a"), path("hard")},
        Pair{path("soft"), path("a")}, Pair{path("dangling"), path("later")}}) {
    EXPECT_THAT(refusal({"--record", record, "--report", report}),
                AllOf(HasSubstr("--report and --record name the same file"),
                      HasSubstr("give another path")))
        << record << " " << report;
    EXPECT_THAT(refusal({"--role", "observer", "--record", record, "--view", report}),
                HasSubstr("--record and --view name the same file"));
  }
  const auto reads = [&](const std::string& record, const std::string& recording) {
    return refusal({"--device", "replay:" + recording, "--record", record});
  };
  EXPECT_THAT(reads(path("hand.csv"), path("hand.csv")),
              HasSubstr("--record and --device name the same file"));
  EXPECT_THAT(reads(path("sub/../hand.csv"), path("hand.csv")),
              HasSubstr("what is read would be overwritten"));
  EXPECT_EQ(text_of(folder / "a"), "text");
  // Accept different files, and device files such as /dev/null.
  EXPECT_FALSE(
      std::holds_alternative<int>(parsed({"--record", path("a"), "--report", path("hand.csv")})));
  EXPECT_FALSE(
      std::holds_alternative<int>(parsed({"--record", "/dev/null", "--report", "/dev/null"})));
}

TEST(Options, TheLimitsOfARecordingsFilesAreOfMcapFiles) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "hand.mcap";
  const auto options = std::get<ClientOptions>(
      parsed({"--record", file, "--record-max-mib", "64", "--record-max-seconds", "600"}));
  EXPECT_EQ(options.files.record_limits.mebibytes, 64.0);
  EXPECT_EQ(options.files.record_limits.seconds, 600.0);
  EXPECT_FALSE(std::get<ClientOptions>(parsed({"--record", file})).files.record_limits.any());
  EXPECT_THAT(refusal({"--record", folder / "hand.csv", "--record-max-mib", "64"}),
              HasSubstr("give --record FILE.mcap"));
  EXPECT_THAT(refusal({"--record-max-seconds", "60"}), HasSubstr("give --record FILE.mcap"));
  EXPECT_THAT(refusal({"--record", file, "--record-max-mib", "0.5"}),
              HasSubstr("--record-max-mib must be 1 MiB or more"));
  EXPECT_THAT(refusal({"--record", file, "--record-max-seconds", "nan"}),
              HasSubstr("--record-max-seconds must be 1 s or more"));
  // A recording with a size limit writes numbered files.
  EXPECT_THAT(
      refusal({"--record", file, "--record-max-mib", "64", "--report", folder / "hand-0001.mcap"}),
      HasSubstr("--report and --record name the same file"));
}

TEST(Options, WhatIsReadIsARegularFile) {
  const testing::TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(refusal({"--token-file", pipe}), HasSubstr("is a pipe; name a regular file"));
  EXPECT_THAT(refusal({"--token-file", "/dev/zero"}), HasSubstr("is a device"));
}

TEST(Options, ControlCharactersAreShownNotObeyed) {
  const std::string said = refusal({"--device", "\x1b]0;owned\x07"});
  EXPECT_THAT(said, HasSubstr("'\\x1b]0;owned\\x07'"));
  EXPECT_EQ(said.find('\x1b'), std::string::npos);
}

TEST(Options, AProfileIsWhereItBegins) {
  const NetworkProfile& thin = network_profile("thin");
  EXPECT_EQ(asked({"--traffic", "thin"}), over(thin, usual_parameters()));
  SessionParameters quick = usual_parameters();
  quick.servo_period = 1.0 / 4000.0;
  EXPECT_EQ(asked({"--rate", "4000", "--traffic", "thin"}), over(thin, quick));
  EXPECT_EQ(asked({"--traffic", "lan"}), usual_parameters());

  SessionParameters more = over(thin, usual_parameters());
  more.packet_interval = 50;
  more.force_deadband = 0.2;
  more.redundancy = 2;
  more.predictor = Predictor::linear;
  more.hold_time = 0.9;
  EXPECT_EQ(asked({"--hold-time", "0.9", "--traffic",
                   "thin,packet_rate=20,force_deadband=20,redundancy=2,predictor=linear"}),
            more);
  EXPECT_FALSE(asked({"--traffic", "thin", "--mode", "virtual_coupling"}).local_model);
  EXPECT_THAT(refusal({"--traffic", "moon"}), HasSubstr("choose one of: lan wan thin"));
}

TEST(Options, HowLongAForceMayStayIsForTheUserToSay) {
  const auto of = [](const std::vector<std::string>& words) {
    return std::get<ClientOptions>(parsed(words));
  };
  // The default is the hold time, because nobody holds a simulated device.
  EXPECT_EQ(of({}).hold.let_go_after, 0.1);
  EXPECT_EQ(of({"--device", "haply"}).hold.let_go_after, 0.0);
  EXPECT_EQ(of({"--let-go-after", "0.02"}).hold.let_go_after, 0.02);
  for (const char* wrong : {"0", "-1", "1.1", "inf", "nan"})
    EXPECT_THAT(refusal({"--let-go-after", wrong}), HasSubstr("--let-go-after must be above 0"));
  EXPECT_THAT(refusal({"--let-go-after", "0.001"}), HasSubstr("two periods of the servo or more"));
  EXPECT_EQ(of({"--let-go-after", "0.001", "--rate", "4000"}).hold.let_go_after, 0.001);
  EXPECT_EQ(of({}).hold.longest, 0.0);
  EXPECT_EQ(of({"--longest-hold-time", "0.8"}).hold.longest, 0.8);
  EXPECT_EQ(of({"--hold-time", "0.3", "--longest-hold-time", "0.3"}).hold.longest, 0.3);
  for (const char* wrong : {"0.2", "1.1", "inf", "nan"})
    EXPECT_THAT(refusal({"--hold-time", "0.3", "--longest-hold-time", wrong}),
                HasSubstr("--longest-hold-time must be from --hold-time to 1 s"));
}

TEST(Options, BusyPollInMicrosecondsOrForEver) {
  EXPECT_EQ(std::get<ClientOptions>(parsed({})).busy_poll, 0.0);
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--busy-poll", "50"})).busy_poll, 50.0);
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--busy-poll", "inf"})).busy_poll, HUGE_VAL);
  EXPECT_THAT(refusal({"--busy-poll", "-1"}), HasSubstr("--busy-poll"));
  EXPECT_THAT(refusal({"--busy-poll", "nan"}), HasSubstr("--busy-poll"));
}

TEST(Options, AnObserverLooksAtTheRateOfPictures) {
  const auto of = [](std::vector<std::string> words) {
    words.insert(words.end(), {"--role", "observer"});
    const auto options = parsed(words);
    EXPECT_TRUE(std::holds_alternative<ClientOptions>(options));
    return std::get<ClientOptions>(options);
  };
  EXPECT_EQ(of({}).role, Role::observer);
  EXPECT_EQ(of({}).parameters.packet_interval, 10);
  EXPECT_EQ(of({"--rate", "50"}).parameters.packet_interval, 1);
  EXPECT_EQ(of({"--traffic", "packet_rate=500"}).parameters.packet_interval, 2);
  EXPECT_EQ(of({"--traffic", "thin"}).parameters.packet_interval, 80);
  EXPECT_EQ(of({"--view", "seen.csv"}).files.view, "seen.csv");
  const auto usual = parsed({});
  EXPECT_EQ(std::get<ClientOptions>(usual).role, Role::operator_);
  EXPECT_EQ(std::get<ClientOptions>(usual).parameters.packet_interval, 1);
  EXPECT_THAT(refusal({"--role", "admin"}), HasSubstr("operator, pointer or observer"));
  EXPECT_THAT(refusal({"--role", "king"}), HasSubstr("observer"));
  EXPECT_THAT(refusal({"--view", "seen.csv"}), HasSubstr("--role observer"));
}

TEST(Options, WhatTheCommandLineLeavesOutMayBeAVariable) {
  ::setenv("FELTWIRE_CLIENT_DURATION", "7", 1);
  ::setenv("FELTWIRE_CLIENT_LOCAL_MODEL", "whole", 1);
  ::setenv("FELTWIRE_CLIENT_DEVICE", "simulated:center=1,2,3", 1);
  ::setenv("FELTWIRE_CLIENT_RATE", "500", 1);
  const auto options = parsed({"--rate", "2000", "--traffic", "wan"});
  for (const char* name : {"FELTWIRE_CLIENT_DURATION", "FELTWIRE_CLIENT_LOCAL_MODEL",
                           "FELTWIRE_CLIENT_DEVICE", "FELTWIRE_CLIENT_RATE"})
    ::unsetenv(name);
  ASSERT_TRUE(std::holds_alternative<ClientOptions>(options));
  const auto& given = std::get<ClientOptions>(options);
  EXPECT_EQ(given.duration, 7.0);
  EXPECT_TRUE(given.parameters.local_model);
  EXPECT_TRUE(given.device.own_center);
  EXPECT_EQ(given.device.task.center, Vec3(1, 2, 3));
  EXPECT_EQ(given.parameters.servo_period, 1.0 / 2000.0);
}

TEST(Options, ADriverIsChosenByItsKind) {
  const auto usual = std::get<ClientOptions>(parsed({}));
  EXPECT_EQ(usual.driver->kind, "simulated");
  EXPECT_EQ(usual.device.name, "");
  const auto replay = std::get<ClientOptions>(parsed({"--device", "replay:a:b.csv"}));
  EXPECT_EQ(replay.driver->kind, "replay");
  EXPECT_EQ(replay.device.name, "a:b.csv");
  EXPECT_THAT(refusal({"--device", "pantograph"}),
              AllOf(HasSubstr("unknown device 'pantograph'"), HasSubstr("simulated"),
                    HasSubstr("replay:FILE.csv")));
  // A device name may replace the name of its driver.
  for (const auto& [word, spec, driver] :
       {std::tuple("omega.7", "omega.7", "forcedimension"),
        std::tuple("Omega7", "omega.7", "forcedimension"),
        std::tuple("sigma", "sigma.7", "forcedimension"),
        std::tuple("touch", "touch", "openhaptics"), std::tuple("inverse3", "inverse3", "haply"),
        std::tuple("phantom_premium_1.5", "phantom_premium_1.5", "openhaptics"),
        std::tuple("hapi_2dof", "hapi_2dof", "hapi"),
        std::tuple("virtuose_6d", "virtuose_6d", "plugin")})
    EXPECT_THAT(refusal({"--device", word}),
                AllOf(HasSubstr(std::string("--device ") + driver),
                      HasSubstr(std::string("--device simulated --spec ") + spec)));
  // A device of a known family or maker has a driver, even without a specification of its name.
  for (const auto& [word, driver] :
       {std::pair("omega.3", "forcedimension"), std::pair("delta.6", "forcedimension"),
        std::pair("Geomagic Touch", "openhaptics"), std::pair("novint", "falcon"),
        std::pair("inverse3x", "haply")})
    EXPECT_THAT(refusal({"--device", word}),
                AllOf(HasSubstr(std::string("unknown device '") + word + "'"),
                      HasSubstr(std::string("give --device ") + driver)));
  for (const std::string& spec : device_spec_names()) {
    // These names are also names of drivers.
    if (spec == "simulated" || spec == "falcon") continue;
    EXPECT_THAT(refusal({"--device", spec}), HasSubstr("--device simulated --spec " + spec));
  }
  EXPECT_THAT(refusal({"--device", "replay"}), HasSubstr("write it as replay:FILE.csv"));
  EXPECT_THAT(refusal({"--device", "replay:"}), HasSubstr("write it as replay:FILE.csv"));
  EXPECT_THAT(refusal({"--device", "simulated:2"}),
              HasSubstr("write it as simulated or simulated:plant=FILE.json"));
  EXPECT_THAT(refusal({"--device", "simulated:plant="}), HasSubstr("plant= has no value"));
  EXPECT_THAT(refusal({"--device", "simulated:"}), HasSubstr("write it as simulated"));
  EXPECT_THAT(refusal({"--device", "simulated:plant=same.json", "--report", "same.json"}),
              HasSubstr("--device"));
  const auto real = parsed({"--device", "simulated:plant=my.json"});
  ASSERT_TRUE(std::holds_alternative<ClientOptions>(real));
  EXPECT_EQ(std::get<ClientOptions>(real).device.name, "plant=my.json");
}

/// The text that the program prints for --help or --help-all.
std::string help(const char* option) {
  std::string program = "feltwire-client", word = option;
  char* words[] = {program.data(), word.data()};
  ::testing::internal::CaptureStdout();
  const auto asked = parse_options(2, words);
  EXPECT_EQ(std::get<int>(asked), 0);
  return ::testing::internal::GetCapturedStdout();
}

TEST(Options, ARoleThatIsNoneIsToldThoseThatThereAre) {
  for (const char* none : {"viewer", "admin", "follower"})
    EXPECT_THAT(
        refusal({"--role", none}),
        HasSubstr("--role must be operator, pointer or observer, is '" + std::string(none) + "'"));
  for (const char* option : {"--help", "--help-all"})
    EXPECT_THAT(help(option), HasSubstr("operator, pointer (a small hand) or observer")) << option;
}

TEST(Options, AValueThatWouldBeMisreadIsRefused) {
  EXPECT_THAT(refusal({"--role", ""}), HasSubstr("--role: is empty; leave it out"));
  EXPECT_THAT(refusal({"--record=", "--check"}), HasSubstr("--record: is empty"));
  EXPECT_THAT(refusal({"--traffic", "batch=010"}),
              HasSubstr("--traffic: batch: must be a decimal number without 0 before it, is 010"));
  EXPECT_THAT(refusal({"--device", "simulated:seed=0x10"}),
              HasSubstr("seed: must be a decimal number, is 0x10"));
  EXPECT_THAT(refusal({"--device", "simulated:seed=18446744073709551616"}),
              HasSubstr("seed: is too large"));
  EXPECT_THAT(refusal({"--device", "simulated:center=nan,0,0"}),
              HasSubstr("center of --device must be three finite numbers"));
  EXPECT_THAT(refusal({"--mode", "contact_frame,storage"}),
              HasSubstr("--mode: storage has no value; write storage=VALUE"));
  EXPECT_THAT(refusal({"--traffic", "packet_rate"}), HasSubstr("packet_rate has no value"));
  EXPECT_THAT(refusal({"--traffic", "force_deadband=51"}),
              HasSubstr("force_deadband of --traffic must be from 0 to 50 %"));
  EXPECT_THAT(refusal({"--traffic", "=3"}), HasSubstr("there is no name before =3"));
}

TEST(Options, NumbersOfTheDeviceMayBeTold) {
  const auto told =
      std::get<ClientOptions>(parsed({"--device", "simulated:damping=0.1,0.2,0.3,mass=0.04"}))
          .device.spec;
  EXPECT_EQ(told.damping, Damping(Vec3(0.1, 0.2, 0.3)));
  EXPECT_EQ(told.mass, 0.04);
  const auto refused = [](const std::string& setting) {
    return refusal({"--device", "simulated:" + setting});
  };
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--device", "falcon:damping=0.1"})).device.spec.damping,
            Damping(0.1));
  EXPECT_THAT(refused("damping=1,2"), HasSubstr("BX,BY,BZ"));
  EXPECT_THAT(refused("damping=-1"), HasSubstr("damping"));
  EXPECT_THAT(refused("mass=1e9"), HasSubstr("check the unit"));
  EXPECT_THAT(refusal({"--spec", "tuch"}), HasSubstr("touch"));
}

TEST(Options, TheHelpFitsOnAScreenAndHasAllOptionsElsewhere) {
  const std::string brief = help("--help"), all = help("--help-all");
  test::expect_one_screen(brief);
  EXPECT_THAT(brief, AllOf(HasSubstr("--connect"), HasSubstr("identify"), HasSubstr("--help-all"),
                           Not(HasSubstr("dead_zone")), Not(HasSubstr("FELTWIRE_CLIENT_"))));
  EXPECT_THAT(all, AllOf(HasSubstr("\n  dead_zone FLOAT=0.1"), HasSubstr("satellite"),
                         HasSubstr("\n  storage TEXT=minimal"), HasSubstr("\n  redundancy INT=3"),
                         HasSubstr("--connect")));
  // The descriptions of the settings have a column of their own, also behind a long name.
  EXPECT_THAT(all, AllOf(HasSubstr("\n  position_deadband FLOAT=0   [%]"),
                         HasSubstr("\n  batch INT=1                 Number")));
}

TEST(Options, ABadVariableIsRefusedAsABadOptionIs) {
  ::setenv("FELTWIRE_CLIENT_DURATION", "long", 1);
  EXPECT_THAT(refusal({}), HasSubstr("long"));
  ::unsetenv("FELTWIRE_CLIENT_DURATION");
}

/// The help of all options has a line for each: "  --scene TEXT". The settings have no dashes.
TEST(Options, TheyAreNoMoreThanTheseMany) {
  CLI::App app;
  OptionValues values;
  ClientOptions made;
  add_options(app, values, made);
  constexpr std::size_t kMost = 48;  // with --help; 50 with --help-all and --version
  EXPECT_LE(app.get_options().size(), kMost)
      << "make it a setting of --device, --mode or --traffic, or merge it with another option";
}

TEST(Options, WhatBelongsToADeviceIsInItsWord) {
  const auto of = [](const std::string& device) {
    return std::get<ClientOptions>(parsed({"--device", device}));
  };
  const ClientOptions hand = of("simulated:path=slide,center=0,0.5,-1,plant=my.json,depth=0.02");
  EXPECT_EQ(hand.device.task.path, HandPath::slide);
  EXPECT_EQ(hand.device.task.center, Vec3(0, 0.5, -1));
  EXPECT_EQ(hand.device.task.depth, 0.02);
  EXPECT_EQ(hand.device.name, "plant=my.json");
  EXPECT_EQ(of("simulated:map_scale=2").device_kind, "simulated");
  const ClientOptions falcon = of("falcon:1,deadman_button=3");
  EXPECT_EQ(falcon.device.name, "1");
  EXPECT_EQ(falcon.protection.deadman_button, 3);
  const ClientOptions plugin = of("plugin:a.so,map_scale=2:rate=5,map_scale=3");
  EXPECT_EQ(plugin.device.name, "a.so:rate=5,map_scale=3");
  EXPECT_EQ(plugin.mapping.scale, 2.0);
  EXPECT_EQ(of("replay:a=b,c.csv").device.name, "a=b,c.csv");
  const ClientOptions given = of("falcon:2,firmware=image.bin,await_still=0.5,mass=0.2");
  EXPECT_EQ(given.device.firmware, "image.bin");
  EXPECT_EQ(given.protection.still, 0.5);
  EXPECT_EQ(given.device.spec.mass, 0.2);

  const auto refused = [](const std::string& device) { return refusal({"--device", device}); };
  EXPECT_THAT(refused("simulated:dept=0.01"),
              HasSubstr("--device simulated: dept is no setting; did you mean depth?"));
  EXPECT_THAT(refused("simulated:path=slide,dept=0.01"), HasSubstr("did you mean depth?"));
  EXPECT_THAT(refused("simulated:depth=1cm"),
              HasSubstr("write the number without unit, in m: 0.01"));
  EXPECT_THAT(refused("haply:firmware=a.bin"), HasSubstr("firmware of --device is for falcon"));
  EXPECT_THAT(refused("haply:steer_speed=0.1"), HasSubstr("is for gamepad and spacemouse"));
  EXPECT_THAT(refused("replay:a.csv,path=slide"), HasSubstr("is for a simulated hand"));
}

/// A misspelled setting would be a part of the device's name, and have no effect.
TEST(Options, AMisspelledFirstSettingIsNoPartOfAName) {
  const auto refused = [](const std::string& device) { return refusal({"--device", device}); };
  EXPECT_THAT(refused("gamepad:event5,steer_speeed=1"),
              HasSubstr("--device gamepad: steer_speeed is no setting; did you mean steer_speed?"));
  EXPECT_THAT(refused("haply:map_scal=3"), HasSubstr("did you mean map_scale?"));
  EXPECT_THAT(refused("gamepad:event5,"), HasSubstr("behind the last; remove a comma"));
  EXPECT_THAT(refused("haply:colour=3"), HasSubstr("colour is no setting; --help-all lists them"));
  EXPECT_THAT(refused("replay:a.csv,map_scal=3"), HasSubstr("did you mean map_scale?"));
  EXPECT_THAT(refused("simulated,depth=0.01"),
              HasSubstr("write a colon behind the kind: simulated:depth=0.01"));
}

TEST(Options, APluginGetsNoSettingOfTheClientUnseen) {
  const auto refused = [](const std::string& device) { return refusal({"--device", device}); };
  EXPECT_THAT(refused("plugin:X.so:0.2,map_scale=2"),
              HasSubstr("map_scale=2 stands behind the second colon, so the plugin gets it and the "
                        "client does not; write it before: plugin:X.so,map_scale=2:..."));
  // A movement is of the simulated hand only, so a plugin may have an argument of this name.
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--device", "plugin:X.so:0.2,depth=2"})).device.name,
            "X.so:0.2,depth=2");
}

TEST(Options, ASettingThatCannotBeIsToldItsRemedy) {
  const auto refused = [](const std::string& settings) {
    return refusal({"--device", "simulated:" + settings});
  };
  EXPECT_THAT(refused("center=1,2"),
              HasSubstr("--device: center has 2 values; write 3, with commas between them"));
  EXPECT_THAT(refused("depth=0.01,0.02"), HasSubstr("depth has 2 values; write 1"));
  EXPECT_THAT(refused("depth=0.01,depth=0.02"), HasSubstr("depth is given twice; write it once"));
  EXPECT_THAT(refused("depth="), HasSubstr("depth= has no value; write it behind the ="));
  EXPECT_THAT(refused(",depth=0.01"), HasSubstr("nothing between two commas, or behind the last"));
  EXPECT_THAT(refused("depth=0.01,"), HasSubstr("remove a comma"));
  EXPECT_THAT(refused("depth=0.01,,radius=0.1"), HasSubstr("remove a comma"));
  EXPECT_THAT(refused("seed=-1"), HasSubstr("seed: must be 0 or more, is -1"));
  EXPECT_THAT(refused("frequency=-1"), HasSubstr("frequency of --device must be 0 or more [Hz]"));
  EXPECT_THAT(refused("tremor=-1"), HasSubstr("tremor of --device must be 0 or more [m]"));
  EXPECT_THAT(refused("radius=nan"), HasSubstr("radius of --device must be 0 or more [m]"));
  EXPECT_THAT(refused("lead_in=0"), HasSubstr("lead_in of --device must be above 0 [s]"));
  EXPECT_THAT(refused("depth=inf"), HasSubstr("depth of --device must be a finite number [m]"));
}

TEST(Options, WhatBelongsToABoundIsInItsMode) {
  const auto of = [](const std::string& mode) {
    return std::get<ClientOptions>(parsed({"--mode", mode}));
  };
  const ClientOptions made =
      of("contact_frame,side=both,projection=joint,storage=elastic,operator_damping=2,account=on");
  EXPECT_EQ(made.parameters.mode, "contact_frame");
  EXPECT_EQ(made.parameters.side, BoundingSide::both);
  EXPECT_EQ(made.parameters.projection, Projection::joint);
  EXPECT_EQ(made.parameters.storage, Storage::elastic);
  EXPECT_EQ(made.parameters.operator_damping, 2.0);
  EXPECT_TRUE(made.servo.account);
  EXPECT_FALSE(of("per_axis,account=off").servo.account);
  const ClientOptions coupling =
      of("virtual_coupling,coupling_stiffness=900,coupling_damping=2,tool_mass=0.1");
  EXPECT_EQ(coupling.parameters.coupling_stiffness, 900.0);
  EXPECT_EQ(coupling.parameters.coupling_damping, 2.0);
  EXPECT_EQ(coupling.parameters.tool_mass, 0.1);
  EXPECT_EQ(of("passivity_control,reference=following").parameters.reference,
            PassivityReference::following);

  const auto refused = [](const std::string& mode) { return refusal({"--mode", mode}); };
  EXPECT_THAT(refused("contact_frame,storag=elastic"),
              HasSubstr("--mode: storag is no setting; did you mean storage?"));
  EXPECT_THAT(refused("contact_frame:storage=elastic"),
              HasSubstr("write a comma behind the method: contact_frame,storage=elastic"));
  EXPECT_THAT(refused("account=no"), HasSubstr("unknown value of account 'no'"));
  EXPECT_THAT(refused("sideways"), HasSubstr("unknown bounding mode 'sideways'"));
}

TEST(Options, WhatBelongsToDatagramsIsInTheTraffic) {
  const SessionParameters made =
      asked({"--traffic",
             "packet_rate=250,batch=2,redundancy=1,position_deadband=5,force_deadband=10,"
             "predictor=linear,keep_alive=0.022"});
  EXPECT_EQ(made.packet_interval, 4);
  EXPECT_EQ(made.batch, 2);
  EXPECT_EQ(made.redundancy, 1);
  EXPECT_EQ(made.position_deadband, 0.05);
  EXPECT_EQ(made.force_deadband, 0.1);
  EXPECT_EQ(made.predictor, Predictor::linear);
  EXPECT_EQ(made.keep_alive, 0.022);
  EXPECT_THAT(refusal({"--traffic", "wan,packet_rat=5"}),
              HasSubstr("--traffic: packet_rat is no setting; did you mean packet_rate?"));
  EXPECT_THAT(refusal({"--traffic", "packet_rate=0"}),
              HasSubstr("packet_rate of --traffic must be above 0 Hz and at most --rate"));
  // The settings of the mode stay beside a profile.
  EXPECT_EQ(asked({"--traffic", "wan", "--mode", "storage=elastic,operator_damping=2"}).storage,
            Storage::elastic);
  EXPECT_EQ(asked({"--traffic", "wan", "--mode", "operator_damping=2"}).operator_damping, 2.0);
}

/// A value on the command line replaces the whole value of the environment.
TEST(Options, SettingsOfTheEnvironmentEndWithTheirValue) {
  ::setenv("FELTWIRE_CLIENT_TRAFFIC", "redundancy=0,batch=2,packet_rate=100", 1);
  const SessionParameters alone = asked({}), beside = asked({"--traffic", "redundancy=1"});
  ::unsetenv("FELTWIRE_CLIENT_TRAFFIC");
  EXPECT_EQ(alone.batch, 2);
  EXPECT_EQ(beside.redundancy, 1);
  EXPECT_EQ(beside.batch, 1);
}

/// A token in a wrong place must not stand in a log.
TEST(Options, ATokenIsNeverPrinted) {
  const std::string token = "fw_0123456789ab_secret";
  for (const std::vector<std::string>& words : {std::vector<std::string>{token},
                                                {"--token", token},
                                                {"--token=" + token},
                                                {"--rate", token},
                                                {"--device", token},
                                                {"--device", "gamepad:" + token + ",a=1"},
                                                {"--mode", token},
                                                {"--local-model", token},
                                                {"--token-file", token}}) {
    const std::string said = refusal(words);
    EXPECT_THAT(said, Not(HasSubstr("0123456789ab"))) << words.back();
    EXPECT_THAT(said, HasSubstr("feltwire-client: "));
  }
  EXPECT_THAT(refusal({token}), HasSubstr("fw_..."));
  std::string said;
  try {
    options_of({"--connect", "localhost:1", "--scene", "room", "--fingerprint", kPrint, token});
  } catch (const std::invalid_argument& error) {
    said = error.what();
  }
  EXPECT_THAT(said, AllOf(HasSubstr("fw_..."), Not(HasSubstr("secret"))));
}

TEST(Options, AnEmptyVariableIsRefused) {
  for (const char* name : {"FELTWIRE_CLIENT_DEVICE", "FELTWIRE_CLIENT_RATE", "FELTWIRE_CA"}) {
    ::setenv(name, "", 1);
    EXPECT_THAT(refusal({}), HasSubstr(std::string(name) + " is empty; unset it"));
    ::unsetenv(name);
  }
}

TEST(Options, AnOldSpellingIsToldTheNewOne) {
  EXPECT_THAT(refusal({"--path", "slide"}),
              HasSubstr("--path is an old spelling; write --device simulated:path=..."));
  EXPECT_THAT(refusal({"--map-scale=2"}),
              HasSubstr("--map-scale is an old spelling; write --device KIND:map_scale=..."));
  EXPECT_THAT(refusal({"--fixed"}), HasSubstr("--fixed is an old spelling; write --changes none"));
  for (const auto& [old, now] : {std::pair("--list-specs", "feltwire-client devices --specs"),
                                 std::pair("--profile", "--traffic PROFILE"),
                                 std::pair("--packet-rate", "--traffic packet_rate=..."),
                                 std::pair("--redundancy", "--traffic redundancy=..."),
                                 std::pair("--storage", "--mode METHOD,storage=..."),
                                 std::pair("--bounding", "--mode METHOD,side=..."),
                                 std::pair("--no-account", "--mode METHOD,account=off"),
                                 std::pair("--damping", "--device KIND:damping=..."),
                                 std::pair("--firmware", "--device falcon:firmware=..."),
                                 std::pair("--await-still", "--device KIND:await_still=..."),
                                 std::pair("--no-local-model", "--local-model off"),
                                 std::pair("--no-whole-surfaces", "--local-model patches"),
                                 std::pair("--local-model=true", "--local-model whole")})
    EXPECT_THAT(refusal({old}), HasSubstr(std::string(old) + " is an old spelling; write " + now));
  EXPECT_THAT(refusal({"--local-model", "false"}),
              HasSubstr("--local-model false is an old spelling; write --local-model off"));
  ::setenv("FELTWIRE_CLIENT_LOCAL_MODEL", "true", 1);
  EXPECT_THAT(refusal({}), HasSubstr("FELTWIRE_CLIENT_LOCAL_MODEL=true is an old spelling; write "
                                     "--local-model whole"));
  ::unsetenv("FELTWIRE_CLIENT_LOCAL_MODEL");
  ::setenv("FELTWIRE_CLIENT_DEAD_ZONE", "0.2", 1);
  EXPECT_THAT(refusal({}), HasSubstr("FELTWIRE_CLIENT_DEAD_ZONE is an old spelling; write "
                                     "--device gamepad:dead_zone=..."));
  ::unsetenv("FELTWIRE_CLIENT_DEAD_ZONE");
  // A value may look like an option.
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--name", "--path"})).name, "--path");
}

/// Each program has its own variables. A shared FELTWIRE_RECORD made server and client write to one
/// file. A misspelled variable must be an error, because it would have no effect.
TEST(Options, AVariableThatSetsNothingIsRefused) {
  const auto refused_with = [](const char* name) {
    ::setenv(name, "7", 1);
    const std::string said = refusal({});
    ::unsetenv(name);
    return said;
  };
  EXPECT_THAT(refused_with("FELTWIRE_RECORD"),
              HasSubstr("FELTWIRE_RECORD is FELTWIRE_CLIENT_RECORD now"));
  EXPECT_THAT(refused_with("FELTWIRE_CLIENT_DURATOIN"),
              HasSubstr("did you mean FELTWIRE_CLIENT_DURATION?"));
  for (const char* other : {"FELTWIRE_SERVER_RECORD", "FELTWIRE_VERSION", "FELTWIRE_CLIENT_VERSION",
                            "FELTWIRE_CLIENT_SERVICE_HOST", "FELTWIRE_CLIENT_PORT_6720_TCP"}) {
    ::setenv(other, "7", 1);
    EXPECT_TRUE(std::holds_alternative<ClientOptions>(parsed({}))) << other;
    ::unsetenv(other);
  }
}

/// At such a rate no tick comes within the hold time. The session would end at once.
TEST(Options, TheHoldTimeFollowsASlowRateOrIsRefused) {
  const auto hold = [](const std::vector<std::string>& words) {
    return std::get<ClientOptions>(parsed(words)).parameters.hold_time;
  };
  EXPECT_EQ(hold({}), 0.1);
  EXPECT_EQ(hold({"--rate", "10"}), 0.5);
  EXPECT_EQ(hold({"--rate", "25"}), 0.2);
  EXPECT_EQ(hold({"--rate", "50"}), 0.1);
  EXPECT_EQ(hold({"--rate", "10", "--traffic", "wan"}), 0.5);
  EXPECT_EQ(hold({"--rate", "10", "--hold-time", "0.6"}), 0.6);
  EXPECT_EQ(hold({"--rate", "10", "--hold-time", "0.5"}), 0.5);
  EXPECT_THAT(refusal({"--rate", "10", "--hold-time", "0.1"}),
              AllOf(HasSubstr("--hold-time 0.5 or more"), HasSubstr("--rate 50 or more")));
  EXPECT_THAT(refusal({"--hold-time", "0.001"}), HasSubstr("--hold-time 0.005 or more"));
  for (const char* rate : {"5", "9.99", "0", "-1", "nan", "inf", "100001"})
    EXPECT_THAT(refusal({"--rate", rate}), HasSubstr("--rate must be from 10 to 100000 Hz"));
}

/// A server may change only parameters that the owner allows. No admin may remove the bound of a
/// hand.
TEST(Options, ChangesAreForTheOwnerToAllow) {
  const auto takes = [](const std::vector<std::string>& words) {
    return std::get<ClientOptions>(parsed(words)).takes;
  };
  using enum LawsTaken;
  for (const char* device : {"simulated", "replay:x.csv", "haply", "plugin:x.so"})
    EXPECT_EQ(takes({"--device", device, "--link", "delay=0"}), ChangesTaken{}) << device;
  EXPECT_EQ(takes({"--changes", "any"}), (ChangesTaken{any, false}));
  EXPECT_EQ(takes({"--changes", "any", "--device", "replay:x.csv"}), (ChangesTaken{any, false}));
  EXPECT_EQ(takes({"--changes", "safe", "--link", "delay=0"}), (ChangesTaken{safe, true}));
  EXPECT_EQ(takes({"--changes", "safe", "--device", "haply"}), (ChangesTaken{safe, false}));
  EXPECT_THAT(refusal({"--changes", "any", "--device", "haply"}), HasSubstr("--changes safe"));
  EXPECT_THAT(refusal({"--changes", "all"}), HasSubstr("none safe any"));
}

TEST(Options, ANameThatCannotBeSentIsRefusedHere) {
  const std::string most(128, 'x');
  EXPECT_EQ(std::get<ClientOptions>(parsed({"--name", most, "--tool", most})).name, most);
  for (const char* option : {"--name", "--tool"})
    EXPECT_THAT(refusal({option, most + "x"}),
                AllOf(HasSubstr(option), HasSubstr("has 129 bytes; at most 128")));
}

TEST(Options, AWordThatIsNearlyAnOptionIsUnderstood) {
  EXPECT_THAT(refusal({"--duraton", "5"}), HasSubstr("did you mean --duration?"));
  EXPECT_THAT(refusal({"--wholly-unknown"}), ::testing::Not(HasSubstr("did you mean")));
}

}  // namespace
}  // namespace feltwire::options_test
