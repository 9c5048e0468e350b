#pragma once
// A recorded link: the fate of probes, from a CSV file with the columns t,delay,lost.

#include <cmath>
#include <filesystem>
#include <istream>
#include <string>
#include <vector>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct LinkTrace {
  struct Row {
    Nanoseconds time;   // since the first row
    Nanoseconds delay;  // one way
    bool lost;
  };
  std::string file;
  std::vector<Row> rows;  // at least one; times rise, the first is 0
  Nanoseconds period;     // > 0, then it begins again: the last time plus one mean step

  /// Returns the row for the time `since` after the first datagram: the newest one not after it.
  const Row& at(Nanoseconds since) const noexcept;
};

inline constexpr double kLongestLinkDelay = 10.0;  // [s]

/// Columns t [s], rising; delay [s], 0 to 10 (not read where lost); lost 0 or 1. Throws CsvError.
LinkTrace read_link_trace(std::istream& in, const std::string& file);
/// Reads a file; throws CsvError also if it cannot be opened.
LinkTrace load_link_trace(const std::filesystem::path& file);

}  // namespace feltwire
