#include "core/base/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace feltwire {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::string quoted(std::string_view text) {
  // Largest number of quoted characters; enough to find the text in the file.
  constexpr std::size_t kLongest = 40;
  std::string out(1, '\'');
  out += text.substr(0, kLongest);
  out += text.size() > kLongest ? "...'" : "'";
  return out;
}

/// Calls use(number, text) for each field, with the number of the field (from 0) and its trimmed
/// text. Returns the number of fields.
template <class Use>
std::size_t for_each_field(std::string_view line, Use use) {
  std::size_t count = 0;
  while (true) {
    const auto comma = line.find(',');
    use(count++, trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return count;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

CsvReader::CsvReader(std::istream& in, std::string file, std::vector<std::string> required,
                     std::vector<std::string> optional, NotFinite not_finite)
    : in_(in), file_(std::move(file)), columns_(std::move(required)), not_finite_(not_finite) {
  const std::size_t required_count = columns_.size();
  columns_.insert(columns_.end(), std::make_move_iterator(optional.begin()),
                  std::make_move_iterator(optional.end()));

  std::string names;
  for (std::size_t i = 0; i < required_count; ++i) names += (i > 0 ? "," : "") + columns_[i];
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  const auto blank = [&] {
    std::string_view line = text_;
    if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
    return trimmed(line).empty();
  };
  bool more = read_line();
  while (more && blank()) more = read_line();
  if (!more) {
    line_ = std::max(line_, 1);
    fail("", "there is no header; the first line must name the columns " + names);
  }
  if (text_.starts_with(kByteOrderMark)) text_.erase(0, kByteOrderMark.size());

  for_each_field(text_, [&](std::size_t, std::string_view field) {
    const auto found = std::find(columns_.begin(), columns_.end(), field);
    const int place =
        found == columns_.end() ? kAbsent : static_cast<int>(found - columns_.begin());
    if (place != kAbsent && std::find(target_.begin(), target_.end(), place) != target_.end())
      fail(field, "the header names it twice; name each column once");
    target_.push_back(place);
  });
  for (std::size_t i = 0; i < required_count; ++i) {
    if (!has(columns_[i]))
      fail(columns_[i],
           "the header " + quoted(trimmed(text_)) + " lacks it; the columns needed are " + names);
  }
}

bool CsvReader::has(std::string_view column) const {
  const auto found = std::find(columns_.begin(), columns_.end(), column);
  const int place = static_cast<int>(found - columns_.begin());
  return std::find(target_.begin(), target_.end(), place) != target_.end();
}

bool CsvReader::read_line() {
  if (!std::getline(in_, text_)) {
    if (in_.bad()) fail("", "reading stopped with an error; check the file or the pipe");
    return false;
  }
  ++line_;
  return true;
}

bool CsvReader::next(std::span<double> row) {
  if (!read_line()) return false;
  if (trimmed(text_).empty()) {
    const int blank = line_;
    while (read_line()) {
      if (trimmed(text_).empty()) continue;
      line_ = blank;
      fail("", "blank line between rows; remove it");
    }
    return false;
  }
  const auto commas = std::count(text_.begin(), text_.end(), ',');
  if (const auto fields = static_cast<std::size_t>(commas) + 1; fields != target_.size()) {
    fail("", std::to_string(fields) + " fields where the header has " +
                 std::to_string(target_.size()) + "; give every row one value a column");
  }
  for_each_field(text_, [&](std::size_t i, std::string_view field) {
    if (target_[i] == kAbsent) return;
    const auto place = static_cast<std::size_t>(target_[i]);
    row[place] = number(field, columns_[place]);
  });
  return true;
}

double CsvReader::number(std::string_view field, std::string_view column) const {
  double value = 0.0;
  const char* const end = field.data() + field.size();
  const auto [rest, error] = std::from_chars(field.data(), end, value);
  if (error == std::errc::result_out_of_range)
    fail(column, quoted(field) + " is beyond what a double can hold; correct the value");
  if (error != std::errc() || rest != end)
    fail(column, quoted(field) + " is not a number; write it like -0.0125 or 1e-3");
  if (not_finite_ == NotFinite::reject && !std::isfinite(value))
    fail(column, quoted(field) + " is not finite; remove the row or repair the value");
  return value;
}

void CsvReader::fail(std::string_view column, std::string_view message) const {
  std::string text = file_ + ":" + std::to_string(line_) + ": ";
  if (!column.empty()) text += "column '" + std::string(column) + "': ";
  throw CsvError(text + std::string(message));
}

}  // namespace feltwire
