#pragma once
// Columns of numbers from a CSV file or a pipe, line by line, with errors that say where and what
// to do.

#include <istream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// Input that cannot be used: what() reads "file:line: column 'x': what is wrong; remedy".
class CsvError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads comma-separated numbers below a header line that names the columns.
///
/// The columns may stand in any order; those that nobody asked for are skipped unread. Spaces
/// around fields, CRLF, a byte order mark and blank lines at the end are tolerated; a row with too
/// few or too many fields, a blank line between rows and anything that is not entirely a number are
/// not.
class CsvReader {
 public:
  enum class NotFinite { reject, accept };

  /// Reads the header. Throws CsvError when there is none, when a required column is missing or
  /// when one that is used is named twice. `file` is only what errors call the input; `in` must
  /// outlive this.
  CsvReader(std::istream& in, std::string file, std::vector<std::string> required,
            std::vector<std::string> optional = {}, NotFinite not_finite = NotFinite::reject);

  /// The next row: the required columns, then the optional ones, in the order they were given
  /// (row.size() is their number). Values of optional columns that the input lacks are left as they
  /// were. False at the end of the input. Throws CsvError.
  bool next(std::span<double> row);

  /// Whether the input has this column.
  bool has(std::string_view column) const;

  /// The number of the line that next() read last, from 1; the header is line 1.
  int line() const { return line_; }

  /// Throws CsvError for that row, naming the column (none when empty): "file:line: column 'x':
  /// message".
  [[noreturn]] void fail(std::string_view column, std::string_view message) const;

 private:
  bool read_line();
  double number(std::string_view field, std::string_view column) const;

  static constexpr int kAbsent = -1;

  std::istream& in_;
  std::string file_;
  std::vector<std::string> columns_;  // required, then optional
  std::vector<int> target_;           // of each field of a line: its place in the row, or kAbsent
  NotFinite not_finite_;
  std::string text_;  // the line, kept so that its memory is used again
  int line_ = 0;
};

}  // namespace feltwire
