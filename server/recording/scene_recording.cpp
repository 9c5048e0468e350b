#include "server/recording/scene_recording.hpp"

#include <utility>

#include "core/build_info/build_info.hpp"
#include "core/recording/event_message.hpp"
#include "core/recording/sample_messages.hpp"

namespace feltwire {

std::map<std::string, std::string> about_recording(const std::string& scene) {
  return {{"kind", "server"},
          {"scene", scene},
          {"version", version()},
          {"build", build_info("feltwire-server")}};
}

void append_event(std::string& out, const SceneEvent& event) {
  append(out, RecordedEvent{.number = event.number,
                            .time = static_cast<std::uint64_t>(event.time.count()),
                            .kind = static_cast<std::uint64_t>(event.kind),
                            .outcome = static_cast<std::uint64_t>(event.outcome),
                            .hand = event.hand,
                            .digest = event.digest,
                            .payload = {reinterpret_cast<const char*>(event.payload.data()),
                                        event.payload.size()}});
}

void attach_scene(mcap::Writer& writer, const CapturedFiles& files, std::uint64_t number,
                  std::uint64_t time) {
  const std::string prefix = "scene-" + std::to_string(number);
  writer.add(mcap::Metadata{prefix, {{"main", files.main}}});
  for (const auto& [name, bytes] : files.files)
    writer.attach(
        {.log_time = time,
         .create_time = time,
         .name = prefix + '/' + name,
         .media_type = name == files.main ? "application/json" : "application/octet-stream",
         .data = bytes});
}

SceneRecording::Part::Part(const SceneRecordingTarget& target, int number)
    : file(numbered(target.file, target.limits, number), "the recording", target.option),
      writer({.library = "feltwire " + version()}) {
  events = writer.add(
      mcap::Channel{writer.add(event_schema()), "/scene/events", std::string(kProtobuf)});
  const std::uint16_t update = writer.add(picture_schema());
  pictures = writer.add(mcap::Channel{update, "/scene/picture", std::string(kProtobuf)});
  auto about = target.about;
  about["part"] = std::to_string(number);
  writer.add(mcap::Metadata{"feltwire", about});
  if (target.shown.message.empty()) return;
  geometry = writer.add(mcap::Channel{update, "/scene/geometry", std::string(kProtobuf)});
  writer.add(mcap::Metadata{"scene", {{"message", target.shown.message}}});
}

SceneRecording::SceneRecording(SceneRecordingTarget target, const CapturedFiles* files,
                               std::int64_t offset)
    : target_(std::move(target)), offset_(offset), part_(std::make_unique<Part>(target_, 1)) {
  if (files != nullptr) attach_scene(part_->writer, *files, 0, 0);
  part_->flush();
}

mcap::Writer& SceneRecording::part_for(std::uint64_t time) {
  const bool begun = part_->writer.messages() > 0;
  if (begun && target_.limits.reached(part_->writer.size() - part_->begun,
                                      time - std::min(time, part_start_))) {
    finish();
    part_ = std::make_unique<Part>(target_, ++number_);
  }
  if (part_->writer.messages() == 0) begin_part(time);
  return part_->writer;
}

void SceneRecording::begin_part(std::uint64_t time) {
  part_start_ = time;
  if (target_.shown.message.empty()) return;
  part_->writer.write(part_->geometry, time, target_.shown.geometry);
  part_->writer.end_chunk();
  part_->begun = part_->writer.size();
}

void SceneRecording::add(const SceneEvent& event, const CapturedFiles* files) {
  const auto time = static_cast<std::uint64_t>(event.time.count() + offset_);
  mcap::Writer& writer = part_for(time);
  if (files != nullptr) attach_scene(writer, *files, event.number, time);
  message_.clear();
  append_event(message_, event);
  writer.write(part_->events, time, message_);
  if (event.kind == EventKind::reload) target_.shown = {};
}

void SceneRecording::see(const Picture& picture) {
  const auto time = static_cast<std::uint64_t>(picture.time.count() + offset_);
  if (!rate_.is_due(time)) return;
  message_.clear();
  gone_.swap(shown_);
  shown_.clear();
  const auto show = [&](std::string id) -> const std::string& {
    gone_.erase(id);
    return *shown_.insert(std::move(id)).first;
  };
  for (const PictureHand& hand : picture.hands)
    if (hand.samples > 0)
      append_hand(message_, time, show("hand " + std::to_string(hand.number)), hand.pose,
                  hand.held);
  for (const PictureBody& body : picture.bodies)
    append_body(message_, time, show("body " + std::to_string(body.object)), body.pose);
  for (const std::string& id : gone_) append_deletion(message_, time, id);
  if (!message_.empty()) part_for(time).write(part_->pictures, time, message_);
}

void SceneRecording::finish() {
  part_->writer.finish();
  part_->flush();
  part_->file.finish();
}

}  // namespace feltwire
