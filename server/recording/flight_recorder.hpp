#pragma once
// The last seconds of a scene in memory, written to the disk after a fault.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/recording/mcap_writer.hpp"
#include "protocol/wire/datagram.hpp"
#include "server/scene/event_log.hpp"
#include "server/scene/session_end.hpp"

namespace feltwire {

/// Keeps the events that the recorder's thread takes from the scene's log. It writes them to a file
/// when a session ends that its client did not end, when a client reports an overdrawn account, or
/// on request. The memory is allocated at construction.
class FlightRecorder {
 public:
  static constexpr Nanoseconds kKept = std::chrono::seconds(10);
  static constexpr std::size_t kRoom = std::size_t{32} << 20;  // [bytes] less time where it is full
  /// A file waits for this time, so that related events are in one file.
  static constexpr Nanoseconds kTogether = std::chrono::milliseconds(200);
  /// Faults that follow each other fill no disk: so long between two files, unless asked for.
  static constexpr Nanoseconds kBetween = std::chrono::seconds(5);

  /// Creates the folder if it is missing. Throws FileError that names it and the reason.
  FlightRecorder(std::filesystem::path folder, std::string name,
                 std::map<std::string, std::string> about, std::int64_t offset);

  void add(const SceneEvent& event);
  /// Writes a file if one is due or `asked` for, logs its name, and returns it. A failure is
  /// logged, too; then there is none.
  std::optional<std::filesystem::path> write_if_due(bool asked, Nanoseconds now) noexcept;

 private:
  std::filesystem::path write(const std::string& reason);
  void note_debt(const SceneEvent& event);
  void want(const SceneEvent& event, const std::string& reason);
  void write_events(mcap::Writer& writer);

  std::filesystem::path folder_;
  std::string name_;
  std::map<std::string, std::string> about_;
  std::int64_t offset_;
  EventQueue kept_{kRoom};
  std::size_t count_ = 0;  // of events in it
  Nanoseconds newest_{0};
  std::string reason_;                        // of the file that is due
  std::optional<Nanoseconds> due_, written_;  // times: of the next file at the earliest; the last
  struct Debt {
    bool stands = false;    // an account is overdrawn, by the newest report
    Nanoseconds written{};  // in a file that became due then
  };
  std::map<std::uint32_t, Debt> debts_;  // of the hands that had one
  SampleBatch batch_;
};

/// Whether such an end came neither from the session's own client nor from the server's end.
bool is_fault(SessionEnd how);

}  // namespace feltwire
