// The configuration file of feltwire-client: each option, relative paths, what overrides it, and
// its errors.

#include "protocol/command_line/config_file.hpp"

#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <fstream>

#include "client/app/add_options.hpp"
#include "tests/client/app/parsed_options.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::options_test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class ConfigFileOfClient : public ::testing::Test {
 protected:
  /// Writes the file and returns its path.
  std::string file(const std::string& json) {
    std::ofstream(path_) << json;
    return path_;
  }
  ClientOptions options(const std::string& json, std::vector<std::string> words = {}) {
    words.insert(words.begin(), {"--config", file(json)});
    auto made = parsed(words);
    if (const int* code = std::get_if<int>(&made)) {
      ADD_FAILURE() << json << " is refused with " << *code;
      return {};
    }
    return std::get<ClientOptions>(std::move(made));
  }
  std::string refused(const std::string& json, std::vector<std::string> words = {}) {
    words.insert(words.begin(), {"--config", file(json)});
    return refusal(words);
  }

  testing::TemporaryFolder folder_;
  const std::string path_ = (folder_ / "hand.json").string();
};

TEST_F(ConfigFileOfClient, SetsNumbersTextsFlagsAndLists) {
  const ClientOptions made = options(R"({
    // a hand behind a narrow line
    "mode": "contact_frame,account=on", "traffic": "packet_rate=100", "local_model": "whole", "rehearsal": false,
    "device": "simulated:center=0,0.5,-0.25,damping=1,2,3", "trust_robot": [0.1, 5], "lead": 0.3, "busy_poll": "inf", "name": "\u00e9 \"left\""
  })");
  EXPECT_EQ(made.parameters.mode, "contact_frame");
  EXPECT_EQ(made.parameters.packet_interval, 10);
  EXPECT_TRUE(made.parameters.local_model);
  EXPECT_FALSE(made.rehearses);
  EXPECT_EQ(made.device.task.center, Vec3(0.0, 0.5, -0.25));
  EXPECT_EQ(made.servo.leads->power, 5.0);
  EXPECT_EQ(made.busy_poll, HUGE_VAL);
  EXPECT_EQ(made.name, "\xc3\xa9 \"left\"");
  EXPECT_TRUE(made.servo.account);
}

TEST_F(ConfigFileOfClient, EveryOptionHasAMember) {
  CLI::App app;
  OptionValues values;
  ClientOptions made;
  add_options(app, values, made);
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty() || option == app.get_help_ptr()) continue;
    std::string name = option->get_lnames().front();
    std::replace(name.begin(), name.end(), '-', '_');
    const bool flag = option->get_items_expected_min() == 0;
    const ConfigFile read =
        read_config(app, "{\"" + name + (flag ? "\": true}" : "\": 1}"), "a.json", {}, {});
    ASSERT_EQ(read.entries.size(), 1U);
    EXPECT_EQ(read.entries[0].option, option->get_lnames().front());
  }
}

TEST_F(ConfigFileOfClient, CommandLineThenEnvironmentOverrideIt) {
  const std::string json = R"({"rate": 500, "name": "of the file"})";
  EXPECT_EQ(options(json).parameters.servo_period, 1.0 / 500.0);
  ::setenv("FELTWIRE_CLIENT_RATE", "250", 1);
  EXPECT_EQ(options(json).parameters.servo_period, 1.0 / 250.0);
  EXPECT_EQ(options(json, {"--rate", "2000"}).parameters.servo_period, 1.0 / 2000.0);
  EXPECT_EQ(options(json).name, "of the file");
  ::unsetenv("FELTWIRE_CLIENT_RATE");
  ::setenv("FELTWIRE_CLIENT_CONFIG", file(json).c_str(), 1);
  const auto made = parsed({});
  ::unsetenv("FELTWIRE_CLIENT_CONFIG");
  ASSERT_TRUE(std::holds_alternative<ClientOptions>(made));
  EXPECT_EQ(std::get<ClientOptions>(made).name, "of the file");
}

TEST_F(ConfigFileOfClient, TheTokenOfTheEnvironmentOverridesItsTokenFile) {
  // parsed() sets FELTWIRE_TOKEN.
  EXPECT_EQ(options(R"({"token_file": "no_such_file", "name": "hand"})").name, "hand");
}

TEST_F(ConfigFileOfClient, CommandLineDropsRivalsFromIt) {
  // parsed() gives --fingerprint, which excludes the other two ways to trust.
  EXPECT_TRUE(std::holds_alternative<Fingerprint>(
      options(R"({"ca": "authority.pem"})").server.credentials.trust));
  EXPECT_EQ(options(R"({"mode": "shaped,side=client", "local_model": "whole"})",
                    {"--mode", "virtual_coupling"})
                .parameters.side,
            BoundingSide::server);
  EXPECT_THAT(refused(R"({"fingerprint_file": "a"})", {"--ca", "b"}), HasSubstr("--ca"));
}

TEST_F(ConfigFileOfClient, ProfileIsOverriddenByItsSettings) {
  const ClientOptions thin = options(R"({"traffic": "thin"})");
  const ClientOptions changed = options(R"({"traffic": "thin,packet_rate=500"})");
  EXPECT_GT(thin.parameters.packet_interval, 2);
  EXPECT_EQ(changed.parameters.packet_interval, 2);
  EXPECT_EQ(changed.parameters.position_deadband, thin.parameters.position_deadband);
}

TEST_F(ConfigFileOfClient, ItsFilesLieInItsFolder) {
  std::ofstream(folder_ / "moved.csv") << "t,x,y,z\n0,0,0,0\n1,0,0,0\n";
  const ClientOptions made = options(
      R"({"report": "out/report.json", "record": "/tmp/r.csv", "flight_recorder": "off",
          "device": "replay:moved.csv", "spec": "touch"})");
  EXPECT_EQ(made.files.report, folder_ / "out/report.json");
  EXPECT_EQ(made.files.record, "/tmp/r.csv");
  EXPECT_EQ(made.files.flight_recorder, std::nullopt);
  EXPECT_EQ(made.device.name, (folder_ / "moved.csv").string());
  EXPECT_EQ(options(R"({"device": "simulated:depth=0.02,plant=lag.json"})").device.name,
            "plant=" + (folder_ / "lag.json").string());
  // The name of the file stands in the text before, too.
  EXPECT_EQ(options(R"({"device": "simulated:plant=plant"})").device.name,
            "plant=" + (folder_ / "plant").string());
  EXPECT_EQ(options(R"({"device": "falcon:1,firmware=1"})").device.firmware,
            (folder_ / "1").string());
  EXPECT_EQ(options(R"({"device": "falcon:1,firmware=1"})").device.name, "1");
  std::ofstream(folder_ / "replay") << "t,x,y,z\n0,0,0,0\n1,0,0,0\n";
  EXPECT_EQ(options(R"({"device": "replay:replay"})").device.name, (folder_ / "replay").string());
  EXPECT_EQ(options(R"({"device": "plugin:a.so,map_scale=2:b,c=1"})").device.name, "a.so:b,c=1");
  EXPECT_THAT(refused(R"({"spec": "none.json"})"), HasSubstr((folder_ / "none.json").string()));
}

TEST_F(ConfigFileOfClient, ErrorsNameFileLineFieldAndRemedy) {
  const auto starts = [&](int line, const std::string& field) {
    return StartsWith("feltwire-client: " + path_ + ":" + std::to_string(line) + ": " + field);
  };
  EXPECT_THAT(refused("{\n\"hold_tim\": 1}"), starts(2, "hold_tim: is no option"));
  EXPECT_THAT(refused("{\n\"hold_tim\": 1}"), HasSubstr("did you mean hold_time?"));
  EXPECT_THAT(refused("{\"hold-time\": 1}"), HasSubstr("did you mean hold_time?"));
  EXPECT_THAT(refused("{\n\n\"rate\": 1}"), starts(3, "rate: --rate must be from 10"));
  EXPECT_THAT(refused("{\n\"rate\": \"fast\"}"), starts(2, "rate: "));
  EXPECT_THAT(refused("{\n\"rate\": [1]}"), starts(2, "rate: has one value"));
  EXPECT_THAT(refused("{\n\"trust_robot\": []}"), starts(2, "trust_robot: is empty"));
  EXPECT_THAT(refused("{\n\"trust_robot\": [1, [2]]}"), starts(2, "trust_robot[1]: "));
  EXPECT_THAT(refused("{\n\"trust_robot\": [1]}"), starts(2, "trust_robot: has 1 values; write 2"));
  EXPECT_THAT(refused("{\n\"trust_robot\": [1, 2, 3]}"),
              starts(2, "trust_robot: has 3 values; write 2"));
  EXPECT_THAT(refused("{\n\"trust_robot\": [\"1,2\", 3]}"), starts(2, "trust_robot[0]: "));
  EXPECT_THAT(refused("{\n\"rehearsal\": 1}"), starts(2, "rehearsal: is on or off"));
  EXPECT_THAT(refused("{\n\"local_model\": 1}"),
              starts(2, "local_model: '1' is none of off, patches, whole"));
  EXPECT_THAT(refused("{\n\"local_model\": true}"),
              starts(2, "local_model: true is an old spelling; write --local-model whole"));
  EXPECT_THAT(refused("{\n\"packet_rate\": 100}"),
              starts(2, "packet_rate: is an old spelling; write --traffic packet_rate=..."));
  EXPECT_THAT(refused("{\n\"no_account\": true}"),
              starts(2, "no_account: is an old spelling; write --mode METHOD,account=off"));
  EXPECT_THAT(refused("{\n\"traffic\": \"wan,packet_rate=0\"}"),
              starts(2, "traffic: packet_rate of --traffic must be above 0"));
  EXPECT_THAT(refused("{\n\"name\": true}"), starts(2, "name: is a number or a text"));
  EXPECT_THAT(refused("{\n\"name\": \"\\ud800\"}"), starts(2, "name: has an escape"));
  EXPECT_THAT(refused("{\n\"ca\": \"a.pem\\u0000b\"}"), starts(2, "ca: has the character \\u0000"));
  // An empty value must not take the next option for its value.
  EXPECT_THAT(refused("{\n\"report\": \"\", \"record\": \"a.csv\"}"),
              starts(2, "report: is empty"));
  EXPECT_THAT(refused("{\n\"name\": \"\"}"), starts(2, "name: is empty"));
  EXPECT_THAT(refused("{\n\"device\": \"omega\"}"), starts(2, "device: "));
  EXPECT_THAT(refused("{\n\"center\": [1, 2, 3]}"),
              starts(2, "center: is an old spelling; write --device simulated:center=..."));
  EXPECT_THAT(refused("{\n\"device\": \"haply:map_scale=0\"}"),
              starts(2, "device: map_scale of --device must be from 0.01"));
  EXPECT_THAT(refused("{\n\"config\": \"b.json\"}"), starts(2, "config: cannot be in a file"));
  EXPECT_THAT(refused("{\n\"list\": true}"), starts(2, "list: cannot be in a file"));
  EXPECT_THAT(refused("{\n\"help\": true}"), starts(2, "help: cannot be in a file"));
  EXPECT_THAT(refused("{\n\"mode\": \"shaped,side=server\"}"), HasSubstr("hand.json"));
  EXPECT_THAT(refused("[]"), HasSubstr("is no object"));
  EXPECT_THAT(refused("rate: 100"), HasSubstr("is YAML, not JSON"));
  EXPECT_THAT(refusal({"--config", "/proc/nowhere/hand.json"}),
              HasSubstr("/proc/nowhere/hand.json"));
  EXPECT_THAT(refusal({"--config"}), HasSubstr("--config"));
  // An error of the command line is none of the file.
  EXPECT_THAT(refused("{\"robot\": 1}", {"--rate", "1"}), StartsWith("feltwire-client: --rate"));
}

TEST_F(ConfigFileOfClient, WordsOfAProgramHaveItToo) {
  ::setenv("FELTWIRE_TOKEN", "fw_of_a_test", 1);
  EXPECT_EQ(options_of({"--connect", "localhost:1", "--scene", "room", "--fingerprint", kPrint,
                        "--config", file(R"({"rate": 500})")})
                .parameters.servo_period,
            1.0 / 500.0);
  EXPECT_THROW(options_of({"--connect", "localhost:1", "--config", file(R"({"rate": 5})")}),
               std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::options_test
