// Takes arbitrary bytes as a control message. A valid message must be equal after it is encoded
// again. Requests of devices and sessions in the message must be possible or refused.

#include "protocol/wire/control.hpp"

#include <stdexcept>

#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

using control::Message;

/// Collects all texts of a message with their lengths. encode() must not shorten them.
struct Texts {
  std::string all;
  void add(const std::string& text) { all += text + "/" + std::to_string(text.size()) + "/"; }

  void operator()(const control::JoinRequest& m) {
    add(m.client);
    add(m.scene);
    add(m.tool);
    add(m.device.name);
    add(m.parameters.mode);
  }
  void operator()(const control::JoinAccepted& m) {
    add(m.tool);
    add(std::string(m.secret_up.text()));
    add(std::string(m.secret_down.text()));
  }
  void operator()(const control::DescribeShapes& m) { add(m.scene); }
  void operator()(const control::GetShape& m) { add(m.scene); }
  void operator()(const control::ShapeDescriptions& m) {
    add(m.scene);
    for (const control::ShapeDescription& shape : m.shapes)
      for (const std::string& text : {shape.name, shape.shape, shape.material, shape.action})
        add(text);
  }
  void operator()(const control::SceneList& m) {
    for (const control::SceneEntry& scene : m.scenes) add(scene.name);
  }
  void operator()(const control::Refused& m) { add(m.reason); }
  void operator()(const control::SetMaterial& m) {
    add(m.scene);
    add(m.change.object);
  }
  void operator()(const control::SetGravity& m) { add(m.scene); }
  void operator()(const control::SceneChanged& m) {
    add(m.scene);
    add(m.what);
  }
  void operator()(const control::WriteFlightRecord& m) { add(m.scene); }
  void operator()(const control::FlightRecordWritten& m) {
    add(m.scene);
    add(m.file);
  }
  void operator()(const control::RecordScene& m) { add(m.scene); }
  void operator()(const control::SceneRecordings& m) {
    for (const std::string& text : {m.scene, m.folder, m.running}) add(text);
    for (const control::KeptRecording& kept : m.kept) add(kept.name);
  }
  void operator()(const control::DescribeSessions& m) { add(m.scene); }
  void operator()(const control::SessionDescriptions& m) {
    for (const control::SessionDescription& session : m.sessions) {
      add(session.client);
      add(session.device);
      add(session.tool);
      add(session.parameters.mode);
    }
  }
  void operator()(const control::DescribeScene& m) { add(m.scene); }
  void operator()(const control::GetCounters& m) { add(m.scene); }
  void operator()(const control::Counters& m) {
    for (const control::Counter& counter : m.counters) add(counter.name);
  }
  template <class Other>
  void operator()(const Other&) {}
};

std::string texts(const Message& message) {
  Texts found;
  std::visit(found, message);
  return found.all;
}

void require_limits(const Message& message) {
  if (const auto* join = std::get_if<control::JoinRequest>(&message))
    require(join->client.size() <= control::kMaxName && join->scene.size() <= control::kMaxName &&
                join->tool.size() <= control::kMaxName &&
                join->device.name.size() <= control::kMaxName,
            "names are no longer than the limit");
  if (const auto* join = std::get_if<control::JoinRequest>(&message))
    require(join->parameters.mode.size() <= kLongestMethodName,
            "nor is the bounding method's name");
  if (const auto* set = std::get_if<control::SetMaterial>(&message))
    require(
        set->scene.size() <= control::kMaxName && set->change.object.size() <= control::kMaxName,
        "nor are those of a scene and an object");
}

/// Allows no exception but std::invalid_argument with a reason.
template <class Value>
void judge(const Value& value) {
  try {
    validate(value);
  } catch (const std::invalid_argument& refused) {
    require(refused.what()[0] != '\0', "a refusal has a reason");
  }
}

void try_body(Bytes body) {
  const auto message = control::decode(body);
  if (!message) return;
  require_limits(*message);
  std::vector<std::uint8_t> frame;
  try {
    frame = control::encode(*message);
  } catch (const std::length_error&) {
    // Tables that shared bytes take more room when each has its own bytes.
    return;
  }
  const Bytes sent = Bytes(frame).subspan(control::kFrameLengthSize);
  require(control::frame_length(std::span<const std::uint8_t, control::kFrameLengthSize>(
              frame.data(), control::kFrameLengthSize)) == sent.size(),
          "a frame says how long it is");
  const auto again = control::decode(sent);
  require(again.has_value() && again->index() == message->index(), "a message stays what it is");
  require(texts(*again) == texts(*message), "names and reasons arrive whole");
  require(control::encode(*again) == frame, "a message says the same when it is sent again");

  if (const auto* join = std::get_if<control::JoinRequest>(&*message)) {
    judge(join->device);
    judge(join->parameters);
  }
  if (const auto* set = std::get_if<control::SetParameters>(&*message)) judge(set->parameters);
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  feltwire::fuzz::try_body({data, size});
  return 0;
}
