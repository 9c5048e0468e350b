#include "sim/report/report_table.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

namespace feltwire::report_table_test {
namespace {

std::filesystem::path write(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::path(::testing::TempDir()) / name;
  std::ofstream(file) << text;
  return file;
}

constexpr const char* kReport = R"({"samples": 1234, "answered": 1230, "lost": 4, "late": 5,
  "round_trip_us": {"p50": 61.2, "p99": 300}, "servo_wakeup_late_us": {"p50": 7}, "max_force_n": 2.345,
  "oscillation_um": 3.14, "displayed_stiffness_n_per_m": null,
  "direction_error_deg": {"mean": 0.125}, "energy_delivered_j": {"elastic": -0.01, "frictional": -0.02},
  "bound_violations": 0})";

TEST(ReportTable, ShowsClientsSideBySide) {
  const std::string table = report_table({write("ann.json", kReport), write("bob.json", kReport)});
  EXPECT_THAT(table, ::testing::HasSubstr("ann"));
  EXPECT_THAT(table, ::testing::HasSubstr("bob"));
  EXPECT_THAT(table, ::testing::ContainsRegex("position samples +1234 +1234"));
  EXPECT_THAT(table, ::testing::ContainsRegex("oscillation in contact, RMS .um. +3\\.1 +3\\.1"));
  EXPECT_THAT(table, ::testing::ContainsRegex("displayed stiffness .N/m. +- +-"));
  EXPECT_THAT(table,
              ::testing::ContainsRegex("largest force on the hand .N. +2\\.3[45] +2\\.3[45]"));
}

/// A column must be as wide as its name, and its numbers must be right-aligned.
TEST(ReportTable, CutsNoNameAndTellsFilesOfOneNameApart) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "another-folder";
  std::filesystem::create_directories(folder);
  const auto first = write("the-left-hand-of-a-long-experiment.json", kReport),
             second = write("another-folder/the-left-hand-of-a-long-experiment.json", kReport),
             third = write("the-left-hand-of-a-long-experience.json", kReport),
             fourth = write("rechte-H\u00e4nde-\x1b[31m-\u00e4\u00f6\u00fc.json", kReport);
  const std::string table = report_table({first, second, third, fourth});
  for (const std::string& name :
       {first.string(), second.string(), std::string("the-left-hand-of-a-long-experience"),
        std::string("rechte-H\u00e4nde-\\x1b[31m-\u00e4\u00f6\u00fc")})
    EXPECT_THAT(table, ::testing::HasSubstr("  " + name));
  EXPECT_THAT(table, ::testing::Not(::testing::HasSubstr("\x1b")));
  // Every line of the table must be as wide as its head, which has four letters of two bytes.
  const std::size_t head = table.find('\n');
  EXPECT_EQ(table.find('\n', head + 1) - head - 1, head - 4);
}

/// A hand whose session got no answer has no round trip, and felt no direction.
TEST(ReportTable, ShowsARunThatFeltNothing) {
  nlohmann::json nothing = nlohmann::json::parse(kReport);
  nothing["round_trip_us"]["p50"] = nothing["direction_error_deg"]["mean"] = nullptr;
  const std::string table = report_table({write("nothing.json", nothing.dump())});
  EXPECT_THAT(table, ::testing::ContainsRegex("round trip, median .us. +-\n"));
  EXPECT_THAT(table, ::testing::ContainsRegex("direction, mean .deg. +-\n"));
}

TEST(ReportTable, NamesTheFileAndTheMissingNumber) {
  const auto file = write("short.json", R"({"samples": 1})");
  EXPECT_THAT([&] { report_table({file}); },
              ::testing::ThrowsMessage<std::runtime_error>(::testing::AllOf(
                  ::testing::HasSubstr("short.json"), ::testing::HasSubstr("/answered"))));
  EXPECT_THAT(
      [&] { report_table({"no-such-report.json"}); },
      ::testing::ThrowsMessage<std::runtime_error>(::testing::HasSubstr("no-such-report.json")));
}

}  // namespace
}  // namespace feltwire::report_table_test
