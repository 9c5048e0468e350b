#include "core/recording/event_message.hpp"

#include "core/recording/feltwire_descriptors.hpp"
#include "core/recording/protobuf.hpp"
#include "core/recording/sample_messages.hpp"

namespace feltwire {

void append(std::string& out, const RecordedEvent& event) {
  using protobuf::put;
  put(out, 1, event.number);
  put(out, 2, event.time);
  put(out, 3, event.kind);
  put(out, 4, event.outcome);
  put(out, 5, event.hand);
  protobuf::put_fixed(out, 6, event.digest);
  put(out, 7, event.payload);
}

std::optional<RecordedEvent> read_event(std::string_view bytes) {
  RecordedEvent event;
  protobuf::Fields fields(bytes);
  bool good = true;
  while (const auto field = fields.next()) {
    const bool is_payload = field->number == 7, is_digest = field->number == 6;
    good = good &&
           (field->number > 7 || (field->is_bytes == is_payload && field->is_fixed64 == is_digest));
    switch (field->number) {
      case 1:
        event.number = field->value;
        break;
      case 2:
        event.time = field->value;
        break;
      case 3:
        event.kind = field->value;
        break;
      case 4:
        event.outcome = field->value;
        break;
      case 5:
        event.hand = field->value;
        break;
      case 6:
        event.digest = field->value;
        break;
      case 7:
        event.payload = field->bytes;
        break;
      default:  // Skip a field from a newer version.
        break;
    }
  }
  return good && fields.ok() ? std::optional(event) : std::nullopt;
}

mcap::Schema event_schema() {
  return {"feltwire.Event", std::string(kProtobuf),
          std::string(reinterpret_cast<const char*>(embedded::feltwire_descriptors),
                      sizeof embedded::feltwire_descriptors)};
}

}  // namespace feltwire
