// Tests that an option has the value that a user means, or refuses it.

#include "protocol/command_line/strict_values.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/command_line/config_file.hpp"

namespace feltwire::strict_values_test {
namespace {

using ::testing::HasSubstr;

struct Options {
  Options() {
    app.add_option("--port", port);
    app.add_option("--seed", seed);
    app.add_option("--offset", offset);
    app.add_option("--rate", rate);
    app.add_option("--seconds", seconds)->check(CLI::Range(1.0, 10.0));
    app.add_option("--trust", trust)->delimiter(',');
    app.add_option("--record", record);
    app.add_flag("--demo", demo);
    app.add_subcommand("add")->add_option("--count", count);
  }
  /// The error of a command line. Empty: there is none.
  std::string error(const std::vector<std::string>& words) {
    try {
      parse_words(app, words);
      return {};
    } catch (const CLI::ParseError& refused) {
      return refused.what();
    }
  }

  CLI::App app{"", "program"};
  int port = 0, count = 0;
  std::uint64_t seed = 0;
  std::int64_t offset = 0;
  double rate = 0.0, seconds = 1.0;
  std::optional<std::pair<double, double>> trust;
  std::string record;
  bool demo = false;
};

std::string error(const std::vector<std::string>& words) { return Options().error(words); }

TEST(StrictValues, WholeNumbersAreDecimal) {
  for (const char* octal : {"010", "06720", "-010", "+010", "00", " 010"})
    EXPECT_THAT(error({"--port", octal}), HasSubstr("--port: must be a decimal number")) << octal;
  for (const char* hexadecimal : {"0x10", "0X10", "-0x10"})
    EXPECT_THAT(error({"--offset", hexadecimal}), HasSubstr("must be a decimal number"));
  EXPECT_THAT(error({"--rate", "0x3e8"}), HasSubstr("must be a decimal number"));
  EXPECT_THAT(error({"add", "--count", "010"}), HasSubstr("--count: must be a decimal number"));
  EXPECT_THAT(error({"--trust", "0x1,2"}), HasSubstr("must be a decimal number"));
  for (const char* good : {"0", "10", "+10", "-10"}) EXPECT_EQ(error({"--offset", good}), "");
  for (const char* good : {"0.5", "00.5", "1e3", "inf", "-0"})
    EXPECT_EQ(error({"--rate", good}), "");
  EXPECT_THAT(error({"--port", "ten"}), HasSubstr("Could not convert")) << "as CLI11 says it";
}

TEST(StrictValues, ANumberBeyondItsTypeIsRefused) {
  EXPECT_THAT(error({"--seed", "18446744073709551616"}), HasSubstr("--seed: is too large"));
  EXPECT_THAT(error({"--seed", "-1"}), HasSubstr("must be 0 or more, is -1"));
  EXPECT_THAT(error({"--offset", "9223372036854775808"}), HasSubstr("is too large"));
  EXPECT_THAT(error({"--offset", "-9223372036854775809"}), HasSubstr("is too large"));
  Options most;
  EXPECT_EQ(most.error({"--seed", "18446744073709551615", "--offset", "-9223372036854775808"}), "");
  EXPECT_EQ(most.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(most.offset, std::numeric_limits<std::int64_t>::min());
}

TEST(StrictValues, NanIsInNoRange) {
  for (const char* none : {"nan", "NaN", "-nan", "nan(1)"})
    EXPECT_THAT(error({"--seconds", none}), HasSubstr("--seconds: must be a number")) << none;
  EXPECT_EQ(error({"--seconds", "5"}), "");
}

TEST(StrictValues, AnEmptyValueIsRefused) {
  const std::string empty = "--record: is empty; leave it out, or give it a value";
  EXPECT_EQ(error({"--record", ""}), empty);
  EXPECT_EQ(error({"--record="}), empty);
  EXPECT_EQ(error({"--record=", "--demo"}), empty) << "CLI11 would take --demo for its value";
  EXPECT_THAT(error({"add", "--count="}), HasSubstr("--count: is empty"));
  Options dashes;
  EXPECT_EQ(dashes.error({"--record", "--seed="}), "") << "a value may look like an option";
  EXPECT_EQ(dashes.record, "--seed=");
}

TEST(StrictValues, AProgramEndsWithItsNameAndTheUsualStatus) {
  Options options;
  const char* const words[] = {"program", "--sede", "1"};
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(ends_at_arguments(options.app, 3, words), 2);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              ::testing::AllOf(::testing::StartsWith("program: "),
                               HasSubstr("; did you mean --seed?; see --help\n")));
  Options good;
  const char* const right[] = {"program", "--seed", "7"};
  EXPECT_EQ(ends_at_arguments(good.app, 3, right), std::nullopt);
  EXPECT_EQ(good.seed, 7u);
}

TEST(ConfigFile, NamesTheHelpThatTheProgramHas) {
  const auto wrong = [](const CLI::App& app) -> std::string {
    try {
      read_config(app, R"({"colour": 1})", "hand.json", {}, {});
      return {};
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  };
  Options options;
  EXPECT_THAT(wrong(options.app), HasSubstr("is no option of this program; --help lists them"));
  options.app.set_help_all_flag("--help-all");
  EXPECT_THAT(wrong(options.app), HasSubstr("; --help-all lists them"));
}

}  // namespace
}  // namespace feltwire::strict_values_test
