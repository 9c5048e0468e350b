#pragma once
// Answers the requests of admins and observers.

#include <asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "protocol/session/live_change.hpp"
#include "protocol/wire/control.hpp"
#include "server/control/control_endpoint.hpp"
#include "server/control/pending_request.hpp"
#include "server/control/request_limits.hpp"
#include "server/control/scene_hosts.hpp"
#include "server/control/session_directory.hpp"
#include "server/control/shape_requests.hpp"

namespace feltwire {

/// Both with their names in the summary.
std::vector<std::pair<std::string_view, std::uint64_t>> named_counters(
    const ControlCounters& connections, const ServiceCounters& requests);

/// Answers admins (evictions, reloads, live changes, flight records, recordings, counters) and
/// observers (the state of a scene and of its sessions). Owns the callbacks to the rest of the
/// server that these requests need. It is on the control thread.
class AdminService {
 public:
  /// The error of a reload; empty: it succeeded.
  using Reloaded = std::function<void(std::optional<control::Refused> refused)>;
  /// Reloads a host's scene, or keeps the old one. It takes its time; `done` is called on the
  /// control thread.
  using Reload = std::function<void(std::size_t host, Reloaded done)>;
  using FlightWritten = std::function<void(std::variant<std::string, control::Refused> outcome)>;
  /// Writes the flight record of a host's scene; `done` is called with its name on the control
  /// thread.
  using WriteFlight = std::function<void(std::size_t host, FlightWritten done)>;
  using Recorded =
      std::function<void(std::variant<control::SceneRecordings, control::Refused> outcome)>;
  /// Starts or stops a recording of a host's scene, or only looks; `done` is called on the control
  /// thread.
  using Record =
      std::function<void(std::size_t host, control::RecordingAction action, Recorded done)>;
  /// Returns the counters of the control port's connections.
  using CountConnections = std::function<ControlCounters()>;

  struct Callbacks {
    Reload reload;
    CountConnections connections = {};  // empty: all zero
    WriteFlight write_flight = {};      // empty: there is no flight recorder
    Record record = {};                 // empty: admins start no recordings
  };
  /// `io` runs on the control thread. All references outlive this.
  AdminService(asio::io_context& io, SceneHosts& hosts, SessionDirectory& directory,
               RequestLimits& limits, Callbacks callbacks);

  /// Answers the request, now or later; false: it is another request, and `asked` is untouched.
  bool handle(PendingRequest& asked, const control::Message& request);

  /// Call it once a second. It frees what belongs to scenes that were loaded again.
  void look_after();

 private:
  bool describe(PendingRequest& asked, const control::Message& request);
  bool describe_shapes(PendingRequest& asked, const control::Message& request);
  std::variant<std::size_t, control::Refused> scene_for(const Token& token, const std::string& name,
                                                        Role role);
  control::Message evict(const Token& token, const control::Evict& request);
  control::Message list_sessions(const Token& token, const control::ListSessions& request);
  void reload(PendingRequest asked, const control::ReloadScene& request);
  void change(PendingRequest asked, const std::string& name, LiveChange change);
  void change_session(PendingRequest asked, std::uint64_t session, LiveChange change);
  void write_flight(PendingRequest asked, const control::WriteFlightRecord& request);
  void record(PendingRequest asked, const control::RecordScene& request);
  void count(PendingRequest asked, const control::GetCounters& request);

  asio::io_context& io_;
  SceneHosts& hosts_;
  SessionDirectory& directory_;
  RequestLimits& limits_;
  Callbacks callbacks_;
  ShapeParts shape_parts_;
};

}  // namespace feltwire
