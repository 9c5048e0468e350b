#include "client/run/flight_record.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/run/mcap_recording.hpp"
#include "core/recording/flight_files.hpp"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {
namespace {

constexpr double kMostTicks = 1e5;  // largest number of stored ticks: 10 s at 10 kHz

/// Texts of the causes, in the order of FlightRecord::causes_.
constexpr std::array kCauseTexts = {"the account was overdrawn", "a lost session goes on",
                                    "the device had a fault"};

}  // namespace

FlightRecord::FlightRecord(FlightTarget target, double servo_period)
    : target_(std::move(target)),
      rows_(
          static_cast<std::size_t>(std::clamp(std::ceil(kKept / servo_period), 1.0, kMostTicks))) {
  make_flight_folder(target_.folder);
}

void FlightRecord::add(const TickRecord& row) noexcept {
  rows_[count_++ % rows_.size()] = row;
  const std::array<bool, kCauses> now = {is_debt(row.balance.value_or(0.0)),
                                         row.no_force == ZeroForceReason::reconnecting,
                                         row.no_force == ZeroForceReason::device_fault};
  for (std::size_t i = 0; i < kCauses; ++i) {
    Cause& cause = causes_[i];
    // A cause that begins again within kKept [s] makes no second file.
    const bool again = cause.began && row.time - *cause.began < kKept;
    if (now[i] && !cause.stands && !again) {
      cause.due = true;
      cause.began = row.time;
    }
    cause.stands = now[i];
  }
}

void FlightRecord::note(std::map<std::string, std::string> values) {
  notes_.push_back({monotonic_now().count(), std::move(values)});
  if (notes_.size() > kMostNotes) notes_.pop_front();
}

std::string FlightRecord::cause() const {
  std::string text;
  for (std::size_t i = 0; i < kCauses; ++i)
    if (causes_[i].due) text += (text.empty() ? "" : "; ") + std::string(kCauseTexts[i]);
  return text;
}

std::optional<std::filesystem::path> FlightRecord::write(const std::string& reason) {
  for (Cause& cause : causes_) cause.due = false;
  if (count_ == 0) return std::nullopt;
  const std::int64_t offset = clock_offset();
  const std::size_t kept = std::min(count_, rows_.size());
  const TickRecord& newest = rows_[(count_ - 1) % rows_.size()];
  const std::filesystem::path file =
      next_flight_file(target_.folder, "client", static_cast<std::uint64_t>(newest.clock + offset));
  RecordingTarget recording{.file = file, .about = target_.about};
  recording.about["kind"] = "flight record";
  recording.about["reason"] = reason;
  McapRecording ticks(std::move(recording), offset);
  for (Note note : notes_) {
    if (note.clock < rows_[(count_ - kept) % rows_.size()].clock) continue;
    note.values["time"] = std::to_string(note.clock + offset);
    ticks.note(note.values);
  }
  Ring<TickRecord> ring(kept);
  for (std::size_t i = count_ - kept; i < count_; ++i) ring.push(rows_[i % rows_.size()]);
  ticks.write(ring);
  ticks.finish();
  return file;
}

}  // namespace feltwire
