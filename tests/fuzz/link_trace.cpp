// Takes arbitrary text as a recorded link. The result must be an error with its place, or a link
// that replays endlessly.

#include <sstream>

#include "client/emulated_link/link_model.hpp"
#include "core/base/csv.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

void play(const LinkTrace& trace) {
  require(!trace.rows.empty() && trace.rows.front().time == Nanoseconds(0), "a trace begins at 0");
  require(trace.period > Nanoseconds(0), "a trace takes time");
  for (std::size_t i = 1; i < trace.rows.size(); ++i)
    require(trace.rows[i - 1].time < trace.rows[i].time, "time rises");
  for (const LinkTrace::Row& row : trace.rows) {
    require(row.delay >= Nanoseconds(0) && seconds(row.delay) <= kLongestLinkDelay,
            "delays are possible");
    require(row.time < trace.period || trace.rows.size() == 1, "the period holds every row");
    require(trace.at(row.time).time == row.time, "each instant meets its own row");
    require(trace.at(row.time + trace.period).time == row.time, "and so again");
  }
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  try {
    std::istringstream in(fuzz::text(data, size));
    fuzz::play(read_link_trace(in, "trace.csv"));
  } catch (const CsvError& error) {
    fuzz::require_place(error.what(), "trace.csv");
  }
  return 0;
}
