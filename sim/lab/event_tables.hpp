#pragma once
// The hands of a server's recording or flight record as tables.

#include <cstdint>
#include <map>
#include <optional>

#include "protocol/wire/datagram.hpp"
#include "server/scene/event_log.hpp"
#include "sim/lab/recording_tables.hpp"

namespace feltwire {

/// Makes three tables for a hand: "/hand_1/sample" has each sample once, also one that came only
/// with a later datagram; "/hand_1/report" has what its client reported; "/hand_1/reply" the
/// replies. Observers and robots have none.
class EventTables {
 public:
  /// Adds to `tables`, which must outlive this.
  explicit EventTables(RecordingTables& tables) : tables_(tables) {}

  /// `log_time` [ns] since 1970. False: the event is a datagram that is none.
  bool add(const SceneEvent& event, std::uint64_t log_time);
  /// Adds the payload of the reply to an event that was added before.
  void add_reply(const SceneEvent& event, std::uint64_t log_time, Bytes payload);

 private:
  struct Hand {
    bool feels = true;                   // not an observer and not a robot
    std::optional<Nanoseconds> start{};  // of its first sample, by its client's clock
    std::uint64_t newest = 0;            // index of its newest sample
  };

  void add_samples(std::uint32_t number, Hand& hand, std::uint64_t log_time);

  RecordingTables& tables_;
  std::map<std::uint32_t, Hand> hands_;
  SampleBatch batch_;
  Reply reply_;
};

}  // namespace feltwire
