#pragma once
// Reads columns of numbers from a CSV file or a pipe, line by line. Errors name the place and the
// remedy.

#include <istream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// Unusable input. what() is "file:line: column 'x': what is wrong; remedy".
class CsvError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads comma-separated numbers below a header line that names the columns.
///
/// The columns may have any order; columns that were not requested are skipped unread. It accepts
/// spaces around fields, CRLF, a byte order mark and blank lines at the end. It refuses a row with
/// too few or too many fields, a blank line between rows and a field that is not entirely a number.
class CsvReader {
 public:
  enum class NotFinite { reject, accept };

  /// Reads the header. Throws CsvError if there is none, if a required column is missing or if a
  /// used column is named twice. `file` is only the name in errors; `in` must outlive this.
  CsvReader(std::istream& in, std::string file, std::vector<std::string> required,
            std::vector<std::string> optional = {}, NotFinite not_finite = NotFinite::reject);

  /// Reads the next row: the required columns, then the optional ones, in the order in which they
  /// were given (row.size() is their number). Values of missing optional columns stay unchanged.
  /// False at the end of the input. Throws CsvError.
  bool next(std::span<double> row);

  /// Whether the input has this column.
  bool has(std::string_view column) const;

  /// The number of the line that next() read last, from 1; the header is line 1.
  int line() const { return line_; }

  /// Throws CsvError for that row. It names the column (unless it is empty): "file:line: column
  /// 'x': message".
  [[noreturn]] void fail(std::string_view column, std::string_view message) const;

 private:
  bool read_line();
  double number(std::string_view field, std::string_view column) const;

  static constexpr int kAbsent = -1;

  std::istream& in_;
  std::string file_;
  std::vector<std::string> columns_;  // required, then optional
  std::vector<int> target_;           // for each field of a line: its place in the row, or kAbsent
  NotFinite not_finite_;
  std::string text_;  // the line; kept to reuse its memory
  int line_ = 0;
};

}  // namespace feltwire
