#pragma once
// The last seconds of a client's servo ticks in memory. They are written to the disk if the run
// ended with an error or its account was overdrawn.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/servo/tick_record.hpp"

namespace feltwire {

/// The folder for flight records, and their metadata of the run.
struct FlightTarget {
  std::filesystem::path folder;
  std::map<std::string, std::string> about{};
};

class FlightRecord {
 public:
  static constexpr double kKept = 10.0;  // [s]

  /// Creates the folder if it is missing, and allocates room for ticks with this servo period [s].
  /// Throws FileError, std::bad_alloc.
  FlightRecord(FlightTarget target, double servo_period);

  /// Never allocates.
  void add(const TickRecord& row) noexcept;
  /// Whether an account was overdrawn, and not within kKept of the last file.
  bool debt() const { return debt_; }
  /// Writes the kept ticks, and returns the file; empty: there was no tick. Throws FileError,
  /// std::runtime_error and std::filesystem::filesystem_error.
  std::optional<std::filesystem::path> write(const std::string& reason);

 private:
  FlightTarget target_;
  std::vector<TickRecord> rows_;  // a ring
  std::size_t count_ = 0;         // number of ticks so far
  bool in_debt_ = false;          // the account is overdrawn at the newest tick
  bool debt_ = false;
  std::optional<double> written_;  // [s] time of the newest tick in the last file
};

}  // namespace feltwire
