// The matrices of extremes must pass the product, and detect wrong results.
#include "sim/studies/extremes/extreme_matrix.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "sim/studies/extremes/extreme_parts.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::extreme_matrix_test {
namespace {

using test::text_of;
using ::testing::HasSubstr;
using ::testing::Not;

ExtremeCell exact_cell() {
  return {.stress = "size 1 m", .judged = "sphere", .reference = "force", .allowed = 1e-9};
}

TEST(ExtremeCell, PassesOnlyWhatItHasJudged) {
  ExtremeCell cell = exact_cell();
  EXPECT_FALSE(cell.passed());
  cell.judge(true, 1e-9);
  EXPECT_TRUE(cell.passed());
}

TEST(ExtremeCell, FailsForEachKindOfFault) {
  const auto after = [](const auto& fault) {
    ExtremeCell cell = exact_cell();
    cell.judge(true, 0.0);
    fault(cell);
    return cell.passed();
  };
  EXPECT_FALSE(after([](ExtremeCell& cell) { cell.judge(true, 2e-9); }));
  EXPECT_FALSE(after([](ExtremeCell& cell) { cell.judge(false, 0.0); }));
  EXPECT_FALSE(after([](ExtremeCell& cell) { cell.judge(true, std::nan("")); }));
  EXPECT_FALSE(after([](ExtremeCell& cell) { cell.judge(true, HUGE_VAL); }));
  EXPECT_FALSE(after([](ExtremeCell& cell) { cell.judge(true, 0.0, false); }));
  EXPECT_FALSE(after([](ExtremeCell& cell) { ++cell.holes; }));
}

TEST(ExtremeCell, ARefusalMustNameItsField) {
  ExtremeCell cell = exact_cell();
  cell.refused = "no";
  EXPECT_FALSE(cell.passed());
  cell.refused = "scene: tick: must lie from 0.0001 to 0.01 [s]";
  EXPECT_TRUE(cell.passed());
}

TEST(ExtremeCell, AWarningExcusesAFailureButNoNanAndNoLimit) {
  ExtremeCell cell = exact_cell();
  cell.warned = "object 'heavy' sinks";
  cell.judge(true, 1.0);
  EXPECT_TRUE(cell.passed());
  cell.judge(true, 0.0, false);
  EXPECT_FALSE(cell.passed());
}

TEST(ExtremeMatrix, TheTableHasEveryFailure) {
  ExtremeMatrix matrix{.part = "contact", .title = "worst error"};
  EXPECT_FALSE(matrix.passed());
  matrix.cells = {exact_cell(), exact_cell()};
  matrix.cells[0].judge(true, 3e-10);
  matrix.cells[1].judged = "box";
  matrix.cells[1].judge(true, 2e-3);
  EXPECT_FALSE(matrix.passed());
  EXPECT_THAT(extreme_matrix_table(matrix), HasSubstr("    3e-10    FAILED\n"));
  EXPECT_THAT(extreme_matrix_table(matrix), HasSubstr("FAILED  size 1 m, box: 1 checks"));
}

class ExtremeParts : public ::testing::TestWithParam<ExtremePart> {};

TEST_P(ExtremeParts, EveryCellPasses) {
  const ExtremeMatrix matrix = GetParam().run(1.0);
  EXPECT_EQ(matrix.part, GetParam().name);
  EXPECT_GE(matrix.cells.size(), 40u);
  EXPECT_TRUE(matrix.passed());
  EXPECT_THAT(extreme_matrix_table(matrix), Not(HasSubstr("FAILED")));
  // A matrix of refusals would prove nothing.
  std::size_t ran = 0;
  for (const ExtremeCell& cell : matrix.cells) ran += cell.checks > 0 ? 1 : 0;
  EXPECT_GT(2 * ran, matrix.cells.size());
}

TEST_P(ExtremeParts, AClosedFormThatIsFivePercentWrongIsFound) {
  const ExtremeMatrix matrix = GetParam().run(1.05);
  EXPECT_FALSE(matrix.passed());
  EXPECT_THAT(extreme_matrix_table(matrix), HasSubstr("FAILED"));
}

INSTANTIATE_TEST_SUITE_P(Each, ExtremeParts, ::testing::ValuesIn(kExtremeParts),
                         [](const auto& part) { return std::string(part.param.name); });

TEST(ExtremeMatrix, TheSameBytesEveryTime) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_extreme_matrix";
  for (const char* turn : {"a", "b"})
    write_extreme_matrix(directory / turn, kExtremeParts[2].run(1.0));
  for (const char* file : {"extremes_wire.csv", "extremes_wire.json"}) {
    const std::string text = text_of(directory / "a" / file);
    EXPECT_GT(text.size(), 3000u) << file;
    EXPECT_EQ(text, text_of(directory / "b" / file)) << file;
  }
  std::filesystem::remove_all(directory);
}

TEST(ExtremeMatrix, TheCommandFailsWhenACellFails) {
  const auto directory = std::filesystem::path(::testing::TempDir()) / "feltwire_extreme_exit";
  const auto status = [&](const std::string& options) {
    const std::string command = std::string(FELTWIRE_LAB_PROGRAM) + " extremes --out " +
                                directory.string() + " " + options + " > /dev/null 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(status("--part wire,teleoperation"), 0);
  EXPECT_TRUE(std::filesystem::exists(directory / "extremes_teleoperation.json"));
  EXPECT_FALSE(std::filesystem::exists(directory / "extremes.json"));
  EXPECT_EQ(status("--part wire --assumed-scale 1.05"), 1);
  EXPECT_NE(status("--part nothing"), 0);
  EXPECT_NE(status("--part wire --methods shaped"), 0);
  std::filesystem::remove_all(directory);
}

}  // namespace
}  // namespace feltwire::extreme_matrix_test
