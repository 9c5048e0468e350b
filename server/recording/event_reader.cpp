#include "server/recording/event_reader.hpp"

#include <cstring>

#include "core/base/file_error.hpp"
#include "core/recording/event_message.hpp"
#include "server/scene/session_end.hpp"

namespace feltwire {
namespace {

// [ns] All event times are below this, so that the difference of two of them does not overflow.
constexpr std::uint64_t kLatest = std::uint64_t{1} << 62;

/// Checks that all values are in range, so that EventReader::read() may convert them.
bool is_possible(const RecordedEvent& read) {
  return read.kind > 0 && read.kind < static_cast<std::uint64_t>(EventKind::count_of_kinds) &&
         read.outcome < static_cast<std::uint64_t>(EventOutcome::count_of_outcomes) &&
         read.hand <= ~std::uint32_t{0} && read.time < kLatest &&
         read.payload.size() <= EventQueue::kMostPayload &&
         (read.kind != static_cast<std::uint64_t>(EventKind::path) || read.payload.size() == 2) &&
         (read.kind != static_cast<std::uint64_t>(EventKind::pace) || read.payload.size() == 1) &&
         (read.kind != static_cast<std::uint64_t>(EventKind::end) ||
          (read.payload.size() == 1 && static_cast<std::uint8_t>(read.payload[0]) <=
                                           static_cast<std::uint8_t>(SessionEnd::shut_down)));
}

}  // namespace

bool EventReader::is_event(const mcap::Reader& mcap, const mcap::Message& message) {
  const mcap::Channel& channel = mcap.channels().at(message.channel);
  return channel.schema != 0 && mcap.schemas().at(channel.schema).name == "feltwire.Event";
}

SceneEvent EventReader::read(const mcap::Message& message, const std::string& file) {
  const auto read = read_event(message.data);
  if (!read || !is_possible(*read))
    throw FileError(file + ": event " + std::to_string(message.sequence) +
                    " of it is no feltwire.Event; " + kEventRemedy);
  const std::string_view payload = read->payload;
  payload_.resize((payload.size() + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t));
  if (!payload.empty()) std::memcpy(payload_.data(), payload.data(), payload.size());
  return {.kind = static_cast<EventKind>(read->kind),
          .outcome = static_cast<EventOutcome>(read->outcome),
          .hand = static_cast<std::uint32_t>(read->hand),
          .time = Nanoseconds(static_cast<std::int64_t>(read->time)),
          .digest = read->digest,
          .payload = {reinterpret_cast<const std::uint8_t*>(payload_.data()), payload.size()},
          .number = read->number};
}

}  // namespace feltwire
