// An option on the command line drops the environment options that it excludes.

#include "client/app/rival_options.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <set>

#include "client/command_line/credential_options.hpp"
#include "tests/client/app/parsed_options.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::options_test {
namespace {

using ::testing::HasSubstr;

/// Sets environment variables of options. The destructor unsets them.
class Environment {
 public:
  void set(const std::string& option, const std::string& value) {
    names_.push_back(variable_of({.program = "client", .shared = credential_variables()}, option));
    ::setenv(names_.back().c_str(), value.c_str(), 1);
  }
  Environment() = default;
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  ~Environment() {
    for (const std::string& name : names_) ::unsetenv(name.c_str());
  }

 private:
  std::vector<std::string> names_;
};

/// Options of one command line, each with its value. The value "true" sets a flag.
using OptionList = std::vector<std::pair<std::string, std::string>>;

std::vector<std::string> command_line(const OptionList& given) {
  std::vector<std::string> words;
  for (const auto& [name, value] : given)
    if (value == "false")
      words.push_back("--no-" + name);
    else
      words.push_back(value == "true" ? "--" + name : "--" + name + "=" + value);
  return words;
}

std::string text(const OptionList& given) {
  std::string all;
  for (const std::string& word : command_line(given)) all += " " + word;
  return all;
}

/// Returns true if the parser accepts the words. parsed() adds a fingerprint.
bool accepted(const std::vector<std::string>& words) {
  ::testing::internal::CaptureStderr();
  const bool good = std::holds_alternative<ClientOptions>(parsed(words));
  ::testing::internal::GetCapturedStderr();
  return good;
}

/// Returns options with valid values. An entry with two options is valid only as a pair.
std::vector<OptionList> everything() {
  std::vector<OptionList> all = {{{"device", "simulated"}},
                                 {{"device", "replay:hand.csv"}},
                                 {{"device", "falcon"}},
                                 {{"device", "haply"}},
                                 {{"device", "hapi:/dev/ttyACM0"}},
                                 {{"device", "gamepad"}},
                                 {{"device", "plugin:./x.so"}},
                                 {{"device", "falcon:firmware=novint.bin"}},
                                 {{"check", "true"}},
                                 {{"role", "operator"}},
                                 {{"role", "observer"}},
                                 {{"role", "observer"}, {"view", "seen.csv"}},
                                 {{"lead", "0.3"}},
                                 {{"lead", "0.3"}, {"robot", "left"}},
                                 {{"lead", "0.3"}, {"trust-robot", "0.1,5"}},
                                 {{"mode", "side=client"}},
                                 {{"mode", "side=server"}},
                                 {{"mode", "side=both"}},
                                 {{"mode", "per_axis,side=server,projection=joint"}},
                                 {{"local-model", "whole"}},
                                 {{"local-model", "patches"}},
                                 {{"local-model", "off"}},
                                 {{"mode", "operator_damping=1"}},
                                 {{"mode", "per_axis,account=off"}},
                                 {{"slew", "50"}},
                                 {{"ramp-up", "0.1"}},
                                 {{"velocity-limit", "1"}},
                                 {{"max-force", "3"}},
                                 {{"wait-for-small-force", "0.1"}},
                                 {{"learn-hand-force", "true"}},
                                 {{"traffic", "wan"}},
                                 {{"traffic", "packet_rate=500"}},
                                 {{"traffic", "position_deadband=5"}},
                                 {{"traffic", "force_deadband=5"}},
                                 {{"record", "felt.csv"}},
                                 {{"record", "felt.mcap"}, {"record-max-mib", "5"}},
                                 {{"record", "felt.mcap"}, {"record-max-seconds", "5"}},
                                 {{"report", "run.json"}},
                                 {{"spec", "omega.7"}},
                                 {{"device", "simulated:damping=0.2,await_still=0.1"}},
                                 {{"link", "wifi"}},
                                 {{"changes", "none"}},
                                 {{"changes", "safe"}},
                                 {{"changes", "any"}}};
  for (const BoundingMethod* method : bounding_methods())
    all.push_back({{"mode", std::string(method->name)}});
  return all;
}

bool names(const OptionList& given, const std::set<std::string>& options) {
  for (const auto& [name, value] : given)
    if (options.contains(name)) return true;
  return false;
}

/// Returns true if the pair stays refused, although one option comes from the environment.
bool stays_refused(const OptionList& said, const OptionList& in_environment) {
  // Only --check may drop a protection of the hand.
  if (names(in_environment, {"slew", "ramp-up", "velocity-limit"})) return !names(said, {"check"});
  // Only --check may open another device than the environment names.
  if (names(in_environment, {"device"})) return !names(said, {"check"});
  // These pairs need a third option: --local-model.
  const auto joined = [](const OptionList& one, const OptionList& other) {
    const auto has = [](const OptionList& given, const char* part) {
      return names(given, {"mode"}) && given.front().second.find(part) != std::string::npos;
    };
    // The server bounds with these, and each of the two options drops the other.
    const bool dropped = has(other, "side=server") || has(other, "virtual_coupling") ||
                         has(other, "passivity_control_parallel");
    return (names(one, {"lead"}) && names(other, {"mode", "traffic"}) && !dropped) ||
           (has(one, "side=server") && names(other, {"traffic"}));
  };
  return joined(said, in_environment) || joined(in_environment, said);
}

TEST(RivalOptions, TheCommandLineDecidesForEveryPairThatIsRefusedTogether) {
  std::vector<OptionList> all = everything();
  std::erase_if(all, [](const OptionList& given) { return !accepted(command_line(given)); });
  int pairs = 0;
  for (const OptionList& said : all)
    for (const OptionList& other : all) {
      std::vector<std::string> together = command_line(said);
      for (const std::string& word : command_line(other)) together.push_back(word);
      if (names(said, {other.front().first}) || accepted(together)) continue;
      Environment environment;
      for (const auto& [name, value] : other) environment.set(name, value);
      EXPECT_NE(accepted(command_line(said)), stays_refused(said, other))
          << text(said) << ", and in the environment" << text(other);
      ++pairs;
    }
  EXPECT_GT(pairs, 100);
}

TEST(RivalOptions, EachWayToTrustDropsTheOthers) {
  testing::TemporaryFolder folder;
  const std::string print = folder / "fingerprint", ca = folder / "ca.pem";
  std::ofstream(print) << std::string(64, 'b') << "\n";
  std::ofstream(ca) << "an authority";
  const OptionList ways = {{"fingerprint", kPrint}, {"fingerprint-file", print}, {"ca", ca}};
  ::setenv("FELTWIRE_TOKEN", "fw_of_a_test", 1);
  const auto trusted = [](const std::vector<std::string>& words) {
    return std::get<ClientOptions>(parsed_bare(words)).server.credentials.trust;
  };
  for (const auto& said : ways) {
    for (const std::vector<std::string>& words :
         {command_line({said}), {"--" + said.first, said.second}}) {
      const auto alone = trusted(words);
      Environment environment;
      for (const auto& [name, value] : ways) environment.set(name, value);
      const auto beside = trusted(words);
      ASSERT_EQ(alone.index(), beside.index()) << said.first;
      if (const auto* fingerprint = std::get_if<Fingerprint>(&alone)) {
        EXPECT_EQ(*fingerprint, std::get<Fingerprint>(beside));
      }
    }
  }
  // The parser must refuse two conflicting options from the same source.
  Environment environment;
  environment.set("ca", ca);
  environment.set("fingerprint", kPrint);
  EXPECT_THAT(refusal({}, true), HasSubstr("FELTWIRE_FINGERPRINT_FILE"));
  EXPECT_THAT(refusal({"--fingerprint", kPrint, "--ca", ca}, true), HasSubstr("give one"));
  // A word in the form of an option may be the value of another option.
  EXPECT_THAT(refusal({"--name", "--ca"}, true), HasSubstr("give one"));
}

TEST(RivalOptions, AnOptionThatEndsTheProgramHasNoVariable) {
  Environment environment;
  for (const char* option : {"version", "help", "list", "check"}) environment.set(option, "true");
  const auto options = parsed({"--device", "falcon"});
  ASSERT_TRUE(std::holds_alternative<ClientOptions>(options));
  EXPECT_FALSE(std::get<ClientOptions>(options).list);
  EXPECT_FALSE(std::get<ClientOptions>(options).check);
}

}  // namespace
}  // namespace feltwire::options_test
