#pragma once
// The last seconds of a client's servo ticks in memory. They are written to the disk if the run
// ended with an error, its account was overdrawn, its session was lost or its device had a fault.

#include <array>
#include <cstdint>
#include <deque>
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
  bool required = true;  // false: if the folder cannot be made, the run goes on without the file
};

/// A written flight record, for the report.
struct WrittenFlight {
  std::filesystem::path file;
  std::string cause;
};

class FlightRecord {
 public:
  static constexpr double kKept = 10.0;  // [s]

  /// Creates the folder if it is missing, and allocates room for ticks with this servo period [s].
  /// Throws FileError, std::bad_alloc.
  FlightRecord(FlightTarget target, double servo_period);

  /// Never allocates.
  void add(const TickRecord& row) noexcept;
  /// Keeps an event of this moment, as Recorder::note() would write it. May throw std::bad_alloc.
  void note(std::map<std::string, std::string> values);
  /// The cause of a file that is due: an overdrawn account, a lost session that goes on or a device
  /// fault. It began now, and did not begin within kKept before. Empty: none is due.
  std::string cause() const;
  /// Writes the kept ticks, and returns the file; empty: there was no tick. Throws FileError,
  /// std::runtime_error and std::filesystem::filesystem_error.
  std::optional<std::filesystem::path> write(const std::string& reason);

 private:
  FlightTarget target_;
  std::vector<TickRecord> rows_;  // a ring
  std::size_t count_ = 0;         // number of ticks so far
  struct Note {
    std::int64_t clock = 0;  // [ns] as TickRecord::clock
    std::map<std::string, std::string> values;
  };
  static constexpr std::size_t kMostNotes = 64;
  std::deque<Note> notes_;  // the newest ones
  struct Cause {
    bool stands = false, due = false;  // at the newest tick; and it is in no file yet
    std::optional<double> began{};     // [s] when it was last due
  };
  static constexpr std::size_t kCauses = 3;
  std::array<Cause, kCauses> causes_;
};

}  // namespace feltwire
