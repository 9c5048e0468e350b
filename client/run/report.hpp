#pragma once
// The report of a run: JSON, every key with unit and meaning in docs/devices.md.

#include <optional>
#include <string>
#include <vector>

#include "client/hands/true_energy.hpp"
#include "client/run/changes.hpp"
#include "client/run/flight_record.hpp"
#include "client/run/observer_recorder.hpp"
#include "client/run/rehearsal.hpp"
#include "client/servo/servo.hpp"
#include "client/servo/servo_loop.hpp"
#include "client/transport/transport.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire {

/// The part of a report that is not a count.
struct RunDescription {
  std::string client, scene, server;
  std::string device_kind;  // as given to --device
  RealTime real_time;
  double scene_stiffness = 0.0;  // [N/m] of the stiffest surface; 0: the server did not say
  double busy_poll = 0.0;        // [us] requested; infinity: never asleep
  std::optional<SightCounts> sight = std::nullopt;  // for an observer
  std::string tool = {};                            // its name; empty: it has none
  std::string server_version = {};                  // empty: it did not say
  std::string check = {};                           // JSON of --check; empty: none was made
  const std::deque<Changes::Done>* changes =
      nullptr;  // requested by admins; null: none were possible
  const std::vector<WrittenFlight>* flight_records = nullptr;  // null: there is no flight recorder
  /// SceneFetch::refusal(); empty: the client computes the contact with what it fetched.
  std::string contact_refused = {};
  std::optional<TrueEnergy> true_energy = std::nullopt;  // of a simulated device
  std::optional<Rehearsal> rehearsal = std::nullopt;     // empty: there was none, or not in time
};

/// The report's text. Every number in it is finite; a missing number is null. `link`:
/// DatagramPort::report(). JSON is inserted unchanged, other text as a string, an empty text as
/// null.
std::string report_json(const RunDescription& run, const Servo& servo,
                        const TransportStatistics& transport, const LoopResult& loop,
                        const std::string& link = {});

}  // namespace feltwire
