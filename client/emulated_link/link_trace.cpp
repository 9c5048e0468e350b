#include "client/emulated_link/link_trace.hpp"

#include <algorithm>
#include <array>
#include <sstream>

#include "core/base/csv.hpp"
#include "core/base/file_error.hpp"
#include "core/base/foreign_content.hpp"
#include "core/base/regular_file.hpp"

namespace feltwire {
namespace {

constexpr double kLongestTrace = 1e7;  // [s] longest accepted trace, about four months

}  // namespace

const LinkTrace::Row& LinkTrace::at(Nanoseconds since) const noexcept {
  const auto after =
      std::upper_bound(rows.begin(), rows.end(), since % period,
                       [](Nanoseconds time, const Row& row) { return time < row.time; });
  return after == rows.begin() ? rows.front() : *std::prev(after);
}

LinkTrace read_link_trace(std::istream& in, const std::string& file) {
  CsvReader reader(in, file, {"t", "delay", "lost"});
  LinkTrace trace;
  trace.file = file;
  std::array<double, 3> row{};
  double first = 0.0;
  while (reader.next(row)) {
    const auto& [t, delay, lost] = row;
    if (trace.rows.empty()) first = t;
    if (!(t - first <= kLongestTrace))
      reader.fail("t", "it is more than 1e7 s after the first; give t in seconds");
    const Nanoseconds time = from_seconds(t - first);
    if (!trace.rows.empty() && time <= trace.rows.back().time)
      reader.fail("t",
                  "time must rise from row to row by a nanosecond at least; sort the rows and "
                  "drop repeated ones");
    if (lost != 0.0 && lost != 1.0)
      reader.fail("lost", "it must be 0 or 1; write 1 where the probe never arrived");
    if (lost == 0.0 && !(delay >= 0.0 && delay <= kLongestLinkDelay))
      reader.fail("delay", "it must be from 0 to 10 s, one way; give it in seconds");
    trace.rows.push_back({time, lost == 0.0 ? from_seconds(delay) : Nanoseconds(0), lost == 1.0});
  }
  if (trace.rows.empty()) reader.fail("", "there are no rows below the header; record some probes");
  const Nanoseconds last = trace.rows.back().time;
  const auto steps = static_cast<std::int64_t>(trace.rows.size()) - 1;
  trace.period = std::max(last + (steps > 0 ? last / steps : last), Nanoseconds(1));
  return trace;
}

LinkTrace load_link_trace(const std::filesystem::path& file) {
  constexpr std::size_t kLargest = std::size_t{64} << 20;  // [bytes] about an hour of rows at 1 kHz
  std::istringstream in = [&] {
    try {
      std::string text = read_regular_file(file, kLargest);
      if (const auto foreign = foreign_content(text))
        throw CsvError(file.string() + ": " + *foreign);
      return std::istringstream(std::move(text));
    } catch (const FileError& error) {
      throw CsvError(error.what());
    }
  }();
  return read_link_trace(in, file.string());
}

}  // namespace feltwire
