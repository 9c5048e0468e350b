#pragma once
// The files that a run writes while it continues.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/run/flight_record.hpp"
#include "client/run/observer_recorder.hpp"
#include "client/run/recording.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// Takes the entries in the rings of the servo thread and writes them. If a file cannot be written
/// any more, it is named once on `errors`; the others continue.
class Records {
 public:
  struct Files {
    std::optional<RecordingTarget> recording = {};
    std::optional<std::filesystem::path> view = {};
    bool observes = false;  // views are taken, with or without a file
    OnView on_view = {};
    std::optional<FlightTarget> flight = {};
    double servo_period = 0.0;  // [s] of the flight record's ticks
  };

  /// Throws std::runtime_error that names the file and the reason.
  explicit Records(const Files& files, std::FILE* errors = stderr);

  Ring<TickRecord>* rows() { return recording_ || flight_ ? &rows_ : nullptr; }
  Ring<TimedView>* views() { return observer_ ? &observer_->views() : nullptr; }
  std::optional<SightCounts> sight() const {
    return observer_ ? std::optional(observer_->counts()) : std::nullopt;
  }

  void write() noexcept;
  /// Writes an event of this moment into the recording, if its format has events, and into the next
  /// flight record.
  void note(const std::map<std::string, std::string>& values) noexcept;
  /// Writes the rest, and waits until it is on the disk.
  void finish() noexcept;
  /// Writes the last seconds to a file of their own, and returns it; empty: there is none.
  std::optional<std::filesystem::path> write_flight_record(const std::string& cause) noexcept;
  /// Calls write_flight_record(), and tells the user the file.
  void tell_of_flight_record(const std::string& cause) noexcept;
  /// All flight records so far.
  const std::vector<WrittenFlight>& flight_records() const { return flight_records_; }
  /// Reports that a file is incomplete.
  bool failed() const { return recording_failed_ || view_failed_; }

 private:
  void write_rows() noexcept;
  void open_flight(const Files& files);
  void write_due_flight_record() noexcept;
  template <class Action>
  void attempt(bool& failed, Action action) noexcept;
  void tell(const char* what) const noexcept;

  static constexpr std::size_t kRecordRoom = 1 << 14;  // rows: more than a second at 10 kHz
  std::unique_ptr<Recorder> recording_;
  Ring<TickRecord> rows_{kRecordRoom};
  std::unique_ptr<FlightRecord> flight_;
  std::vector<WrittenFlight> flight_records_;
  std::unique_ptr<Ring<TickRecord>> copied_;  // for the recording, if there are both
  std::unique_ptr<ObserverRecorder> observer_;
  std::FILE* errors_;
  bool recording_failed_ = false, view_failed_ = false;
};

}  // namespace feltwire
