#include "client/run/mcap_recording.hpp"

#include <utility>

#include "core/build_info/build_info.hpp"
#include "core/recording/sample_messages.hpp"

namespace feltwire {
namespace {

RecordedSample sample_of(const TickRecord& row) {
  return {.time = row.time,
          .pose = {row.position, row.orientation},
          .elastic = row.elastic,
          .frictional = row.frictional,
          .held = row.held,
          .torque = row.torque,
          .age = row.age};
}

RecordedAccount account_of(const TickRecord& row) {
  return {.time = row.time,
          .balance = row.balance,
          .cut = row.account_cut,
          .no_force = static_cast<std::uint32_t>(row.no_force)};
}

}  // namespace

McapRecording::Part::Part(const RecordingTarget& target, int number)
    : file(numbered(target, number), "the recording", target.option),
      writer({.library = "feltwire " + version()}) {
  const auto channel = [this](std::uint16_t schema, const char* topic) {
    return writer.add(mcap::Channel{schema, topic, std::string(kProtobuf)});
  };
  sample = channel(writer.add(sample_schema()), "/hand/sample");
  account = channel(writer.add(account_schema()), "/hand/account");
  pose = channel(writer.add(pose_schema()), "/hand/pose");
  const std::uint16_t pictures = writer.add(picture_schema());
  picture = channel(pictures, "/hand/picture");
  scene = channel(pictures, "/scene/picture");
  auto about = target.about;
  about["part"] = std::to_string(number);
  writer.add(mcap::Metadata{"feltwire", about});
  flush();
}

McapRecording::McapRecording(RecordingTarget target, std::int64_t offset)
    : target_(std::move(target)), offset_(offset), part_(std::make_unique<Part>(target_, 1)) {}

bool McapRecording::part_is_over(std::uint64_t time) const {
  return part_->writer.messages() > 0 &&
         target_.limits.reached(part_->writer.size(), time - part_start_);
}

void McapRecording::write(Ring<TickRecord>& rows) {
  TickRecord row;
  while (rows.pop(row)) {
    const auto time = static_cast<std::uint64_t>(row.clock + offset_);
    if (part_is_over(time)) {
      finish();
      part_ = std::make_unique<Part>(target_, ++number_);
    }
    add(row, time);
  }
  part_->flush();
}

void McapRecording::note(const std::map<std::string, std::string>& values) {
  add_metadata("change", values);
}

void McapRecording::mark(const std::string& text) { add_metadata("mark", {{"text", text}}); }

void McapRecording::add_metadata(const std::string& name,
                                 std::map<std::string, std::string> values) {
  values.emplace("time", std::to_string(monotonic_now().count() + offset_));
  part_->writer.add(mcap::Metadata{name, values});
  part_->flush();
}

void McapRecording::finish() {
  part_->writer.finish();
  part_->flush();
  part_->file.finish();
}

void McapRecording::add(const TickRecord& row, std::uint64_t time) {
  mcap::Writer& writer = part_->writer;
  if (writer.messages() == 0) part_start_ = time;
  message_.clear();
  append(message_, sample_of(row));
  writer.write(part_->sample, time, message_);
  message_.clear();
  append(message_, account_of(row));
  writer.write(part_->account, time, message_);
  if (!first_tick_) first_tick_ = time - static_cast<std::uint64_t>(from_seconds(row.time).count());
  if (pictures_.is_due(time)) add_picture(row, time);
}

void McapRecording::add_picture(const TickRecord& row, std::uint64_t time) {
  const Pose pose{row.position, row.orientation};
  message_.clear();
  append_pose(message_, time, pose);
  part_->writer.write(part_->pose, time, message_);
  message_.clear();
  append_hand(message_, time, "hand", pose, row.held);
  part_->writer.write(part_->picture, time, message_);
}

/// Records the observed scene: removed hands and bodies at once, present hands and bodies 60 times
/// per second.
void McapRecording::see(double time, const ObservedScene& scene) {
  if (!first_tick_) return;
  const std::uint64_t now = *first_tick_ + static_cast<std::uint64_t>(from_seconds(time).count());
  message_.clear();
  for (const std::uint32_t hand : scene.hands_gone())
    append_deletion(message_, now, "hand " + std::to_string(hand));
  for (const std::uint16_t body : scene.bodies_gone())
    append_deletion(message_, now, "body " + std::to_string(body));
  if (views_.is_due(now)) {
    for (const auto& [number, hand] : scene.hands())
      append_hand(message_, now, "hand " + std::to_string(number), hand.pose, hand.force);
    for (const auto& [object, body] : scene.bodies())
      append_body(message_, now, "body " + std::to_string(object), body.pose);
  }
  if (!message_.empty()) part_->writer.write(part_->scene, now, message_);
}

}  // namespace feltwire
