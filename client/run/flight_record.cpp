#include "client/run/flight_record.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/run/mcap_recording.hpp"
#include "core/recording/flight_files.hpp"

namespace feltwire {
namespace {

constexpr double kMostTicks = 1e5;  // 10 s at 10 kHz

}  // namespace

FlightRecord::FlightRecord(FlightTarget target, double servo_period)
    : target_(std::move(target)),
      rows_(
          static_cast<std::size_t>(std::clamp(std::ceil(kKept / servo_period), 1.0, kMostTicks))) {
  make_flight_folder(target_.folder);
}

void FlightRecord::add(const TickRecord& row) noexcept {
  rows_[count_++ % rows_.size()] = row;
  const bool owes = row.balance.value_or(0.0) < 0.0;
  const bool again = written_ && row.time - *written_ < kKept;  // it is in the file, or in the next
  debt_ = debt_ || (owes && !in_debt_ && !again);
  in_debt_ = owes;
}

std::optional<std::filesystem::path> FlightRecord::write(const std::string& reason) {
  debt_ = false;
  if (count_ == 0) return std::nullopt;
  const std::int64_t offset = clock_offset();
  const std::size_t kept = std::min(count_, rows_.size());
  const TickRecord& newest = rows_[(count_ - 1) % rows_.size()];
  written_ = newest.time;
  const std::filesystem::path file =
      next_flight_file(target_.folder, "client", static_cast<std::uint64_t>(newest.clock + offset));
  RecordingTarget recording{.file = file, .about = target_.about};
  recording.about["kind"] = "flight record";
  recording.about["reason"] = reason;
  McapRecording ticks(std::move(recording), offset);
  Ring<TickRecord> ring(kept);
  for (std::size_t i = count_ - kept; i < count_; ++i) ring.push(rows_[i % rows_.size()]);
  ticks.write(ring);
  ticks.finish();
  return file;
}

}  // namespace feltwire
