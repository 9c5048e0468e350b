#include "server/recording/flight_recorder.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "core/base/appended_file.hpp"
#include "core/build_info/build_info.hpp"
#include "core/recording/event_message.hpp"
#include "core/recording/flight_files.hpp"
#include "core/recording/recording_files.hpp"
#include "core/recording/sample_messages.hpp"
#include "protocol/wire/codec.hpp"
#include "server/recording/scene_recording.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

std::string reason_of(const SceneEvent& event) {
  return fmt::format("hand {}: {}", event.hand, text(static_cast<SessionEnd>(event.payload[0])));
}

/// Writes the poses of all hands and the forces on them to a file, 60 times a second.
class HandPictures {
 public:
  HandPictures(mcap::Writer& writer, std::uint16_t channel) : writer_(writer), channel_(channel) {}

  void add(const SceneEvent& event, std::uint64_t time) {
    if (event.kind == EventKind::end) {
      hands_.erase(event.hand);
      message_.clear();
      append_deletion(message_, time, "hand " + std::to_string(event.hand));
      writer_.write(channel_, time, message_);
    }
    if (event.kind != EventKind::samples || decode(event.payload, batch_) != DropReason::none ||
        batch_.count < 1)
      return;
    hands_.insert_or_assign(event.hand, batch_.samples[0]);
    if (!rate_.is_due(time)) return;
    message_.clear();
    for (const auto& [number, sample] : hands_)
      append_hand(message_, time, "hand " + std::to_string(number), sample.pose,
                  sample.held.force());
    writer_.write(channel_, time, message_);
  }

 private:
  mcap::Writer& writer_;
  std::uint16_t channel_;
  PictureRate rate_;
  std::map<std::uint32_t, Sample> hands_;
  SampleBatch batch_;
  std::string message_;
};

}  // namespace

bool is_fault(SessionEnd how) {
  switch (how) {
    case SessionEnd::silent:
    case SessionEnd::flooded:
    case SessionEnd::forged:
    case SessionEnd::disturbing:
    case SessionEnd::evicted:
    case SessionEnd::tool_gone:
    case SessionEnd::failed:
      return true;
    case SessionEnd::goodbye:
    case SessionEnd::asked:
    case SessionEnd::shut_down:
      return false;
  }
  return false;
}

FlightRecorder::FlightRecorder(fs::path folder, std::string name,
                               std::map<std::string, std::string> about, std::int64_t offset)
    : folder_(std::move(folder)),
      name_(std::move(name)),
      about_(std::move(about)),
      offset_(offset) {
  make_flight_folder(folder_);
  about_["kind"] = "flight record";
}

void FlightRecorder::add(const SceneEvent& event) {
  newest_ = event.time;
  bool kept = kept_.push(event);
  while (!kept && kept_.take()) {
    --count_;
    kept = kept_.push(event);
  }
  if (kept) ++count_;
  if (event.kind == EventKind::samples) return note_debt(event);
  if (event.kind != EventKind::end) return;
  debts_.erase(event.hand);
  if (is_fault(static_cast<SessionEnd>(event.payload[0]))) want(event, reason_of(event));
}

/// Requests a file when a client reports that its energy account is overdrawn (a debt). Requests no
/// other file while this debt lasts, or if the same hand has another debt within kKept.
void FlightRecorder::note_debt(const SceneEvent& event) {
  if (decode(event.payload, batch_) != DropReason::none || !batch_.report) return;
  const bool owes = batch_.report->has_account && is_debt(batch_.report->balance);
  const auto known = debts_.find(event.hand);
  if (!owes) {
    if (known != debts_.end()) known->second.stands = false;
    return;
  }
  Debt& debt = debts_[event.hand];
  const bool again = debt.stands || (known != debts_.end() && event.time - debt.written < kKept);
  debt.stands = true;
  if (again) return;
  debt.written = event.time;
  want(event, fmt::format("hand {}: its client says that the account is overdrawn", event.hand));
}

void FlightRecorder::want(const SceneEvent& event, const std::string& reason) {
  reason_ += (reason_.empty() ? "" : "; ") + reason;
  if (due_) return;
  due_ = event.time + kTogether;
  if (written_) due_ = std::max(*due_, *written_ + kBetween);
}

std::optional<fs::path> FlightRecorder::write_if_due(bool asked, Nanoseconds now) noexcept {
  if (!asked && !(due_ && now >= *due_)) return std::nullopt;
  std::optional<fs::path> written;
  written_ = newest_;
  try {
    if (asked) reason_ += std::string(reason_.empty() ? "" : "; ") + "asked for";
    fs::path file = write(reason_);
    spdlog::warn("scene {}: {}; flight record: {}", about_["scene"], reason_, file.string());
    written = std::move(file);
  } catch (const std::exception& error) {
    spdlog::error("scene {}: no flight record: {}", about_["scene"], error.what());
  }
  reason_.clear();
  due_.reset();
  return written;
}

fs::path FlightRecorder::write(const std::string& reason) {
  const auto now = static_cast<std::uint64_t>(newest_.count() + offset_);
  fs::path path = next_flight_file(folder_, name_, now);
  AppendedFile file(path, "the flight record", kFlightOption);
  mcap::Writer writer({.library = "feltwire " + version()});
  auto about = about_;
  about["reason"] = reason;
  writer.add(mcap::Metadata{"feltwire", about});
  write_events(writer);
  writer.finish();
  file.append(writer.take());
  file.finish();
  return path;
}

/// Writes the events of the last kKept. Moves each event from the front of the queue to its back,
/// so that the queue still has all events afterwards.
void FlightRecorder::write_events(mcap::Writer& writer) {
  const std::uint16_t events = writer.add(
      mcap::Channel{writer.add(event_schema()), "/scene/events", std::string(kProtobuf)});
  const std::uint16_t pictures = writer.add(
      mcap::Channel{writer.add(picture_schema()), "/scene/picture", std::string(kProtobuf)});
  HandPictures hands(writer, pictures);
  std::string message;
  for (std::size_t i = 0; i < count_; ++i) {
    const SceneEvent event = *kept_.take();
    if (event.time >= newest_ - kKept) {
      const auto time = static_cast<std::uint64_t>(event.time.count() + offset_);
      message.clear();
      append_event(message, event);
      writer.write(events, time, message);
      hands.add(event, time);
    }
    kept_.push(event);
  }
}

}  // namespace feltwire
