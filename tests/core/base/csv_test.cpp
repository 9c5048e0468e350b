#include "core/base/csv.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <sstream>

#include "tests/client/temporary_folder.hpp"

namespace feltwire::csv_test {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Returns all rows of t,x (and optionally y). Throws the reader's errors.
std::vector<std::array<double, 3>> rows(
    const std::string& text, CsvReader::NotFinite not_finite = CsvReader::NotFinite::reject) {
  std::istringstream in(text);
  CsvReader reader(in, "f.csv", {"t", "x"}, {"y"}, not_finite);
  std::vector<std::array<double, 3>> all;
  std::array<double, 3> row{0.0, 0.0, 42.0};
  while (reader.next(row)) all.push_back(row);
  return all;
}
std::string complaint(const std::string& text) {
  return error_of<CsvError>([&] { rows(text); });
}

using Row = std::array<double, 3>;

TEST(Csv, ColumnsStandInAnyOrderAndUnknownOnesAreNotRead) {
  EXPECT_EQ(rows("note,x,t,y\nhello,2,1,3\n,-2.5e-3,1.5,4\n"),
            (std::vector<Row>{{1, 2, 3}, {1.5, -2.5e-3, 4}}));
}

TEST(Csv, AbsentOptionalColumnsKeepTheirValue) {
  EXPECT_EQ(rows("t,x\n1,2\n"), (std::vector<Row>{{1, 2, 42}}));
}

TEST(Csv, ToleratesWhatSpreadsheetsAndEditorsLeaveBehind) {
  EXPECT_EQ(rows("\xEF\xBB\xBFt , x\r\n 1,\t2 \r\n3,4\r\n\r\n\n  \n"),
            (std::vector<Row>{{1, 2, 42}, {3, 4, 42}}));
  EXPECT_EQ(rows("t,x\n1,2"), (std::vector<Row>{{1, 2, 42}}));
}

TEST(Csv, NotFiniteOnlyWhereItIsAsked) {
  const auto accepted = rows("t,x\nnan,-inf\n", CsvReader::NotFinite::accept);
  ASSERT_EQ(accepted.size(), 1u);
  EXPECT_TRUE(std::isnan(accepted[0][0]));
  EXPECT_EQ(accepted[0][1], -std::numeric_limits<double>::infinity());
  EXPECT_THAT(complaint("t,x\n1,2\n3,nan\n"),
              AllOf(StartsWith("f.csv:3: column 'x': 'nan' is not finite"), HasSubstr("; ")));
  EXPECT_THAT(complaint("t,x\ninf,0\n"), StartsWith("f.csv:2: column 't': 'inf' is not finite"));
}

TEST(Csv, ErrorsNameFileLineAndColumn) {
  EXPECT_THAT(complaint(""), AllOf(StartsWith("f.csv:1: there is no header"), HasSubstr("t,x")));
  EXPECT_THAT(complaint("\n1,2\n"), StartsWith("f.csv:2: column 't': the header '1,2' lacks it"));
  EXPECT_THAT(complaint("t,y\n1,2\n"),
              StartsWith("f.csv:1: column 'x': the header 't,y' lacks it"));
  EXPECT_THAT(complaint("t,x,t\n1,2,3\n"),
              StartsWith("f.csv:1: column 't': the header names it twice"));
  EXPECT_THAT(complaint("t,x\n1,2\n1\n"), StartsWith("f.csv:3: 1 fields where the header has 2"));
  EXPECT_THAT(complaint("t,x\n1,2,3\n"), StartsWith("f.csv:2: 3 fields where the header has 2"));
  EXPECT_THAT(complaint("t,x\n1,2\n\n3,4\n"), StartsWith("f.csv:3: blank line between rows"));
}

TEST(Csv, OnlyWholeNumbersAreNumbers) {
  for (const char* field : {"", "abc", "1.5m", "0x10", "1 2", "1e", "--1", "\"1\"", "+1"})
    EXPECT_THAT(complaint("t,x\n1," + std::string(field) + "\n"),
                StartsWith("f.csv:2: column 'x': '" + std::string(field) + "' is not a number"));
  EXPECT_THAT(complaint("t,x\n1e999,0\n"), StartsWith("f.csv:2: column 't': '1e999' is beyond"));
}

TEST(Csv, StreamsRowByRow) {
  // The reader must return the first row before the error in the second row.
  std::istringstream in("t,x\n1,2\n3,oops\n");
  CsvReader reader(in, "f.csv", {"t", "x"});
  std::array<double, 2> row{};
  EXPECT_TRUE(reader.next(row));
  EXPECT_EQ(reader.line(), 2);
  EXPECT_THROW(reader.next(row), CsvError);
  EXPECT_TRUE(reader.has("x"));
  EXPECT_FALSE(reader.has("y"));
}

TEST(Csv, AFileThatCannotBeReadIsNotAnEmptyOne) {
  testing::TemporaryFolder folder;
  std::ifstream directory(folder / ".");
  EXPECT_THAT(error_of<CsvError>([&] { CsvReader(directory, "dir", {"t"}); }), HasSubstr("dir:"));
}

}  // namespace
}  // namespace feltwire::csv_test
