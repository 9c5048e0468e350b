#include "sim/report_table.hpp"

#include <gmock/gmock.h>

#include <fstream>

namespace feltwire::report_table_test {
namespace {

std::filesystem::path write(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) / name;
  std::ofstream(file) << text;
  return file;
}

constexpr const char* kReport = R"({"samples": 1234, "answered": 1230, "lost": 4, "late": 5,
  "round_trip_us": {"p50": 61.2, "p99": 300}, "servo_wakeup_late_us": {"p50": 7}, "max_force_n": 2.345,
  "direction_error_deg": {"mean": 0.125}, "energy_delivered_j": {"elastic": -0.01, "frictional": -0.02},
  "bound_violations": 0})";

TEST(ReportTable, ShowsClientsSideBySide) {
  const std::string table = report_table({write("ann.json", kReport), write("bob.json", kReport)});
  EXPECT_THAT(table, testing::HasSubstr("ann"));
  EXPECT_THAT(table, testing::HasSubstr("bob"));
  EXPECT_THAT(table, testing::ContainsRegex("position samples +1234 +1234"));
  EXPECT_THAT(table, testing::ContainsRegex("largest force on the hand .N. +2\\.3[45] +2\\.3[45]"));
}

TEST(ReportTable, NamesTheFileAndTheMissingNumber) {
  const auto file = write("short.json", R"({"samples": 1})");
  EXPECT_THAT([&] { report_table({file}); },
              testing::ThrowsMessage<std::runtime_error>(testing::AllOf(
                  testing::HasSubstr("short.json"), testing::HasSubstr("/answered"))));
  EXPECT_THAT(
      [&] { report_table({"no-such-report.json"}); },
      testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("no-such-report.json")));
}

}  // namespace
}  // namespace feltwire::report_table_test
