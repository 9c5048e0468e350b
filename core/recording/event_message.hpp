#pragma once
// feltwire.Event (core/recording/feltwire.proto), to Protobuf and back.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/recording/mcap_records.hpp"

namespace feltwire {

struct RecordedEvent {
  std::uint64_t number = 0, time = 0;  // [ns]
  std::uint64_t kind = 0, outcome = 0, hand = 0;
  std::uint64_t digest = 0;
  std::string_view payload{};  // of a message that was read: part of its bytes
};

void append(std::string& out, const RecordedEvent& event);
/// Empty if the bytes are no such message. The numbers may have any value.
std::optional<RecordedEvent> read_event(std::string_view bytes);

mcap::Schema event_schema();

}  // namespace feltwire
