#pragma once
// A recorded movement as a device: it repeats the movement for every force.

#include <atomic>
#include <filesystem>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/device/device.hpp"

namespace feltwire {

struct RecordedPose {
  double time = 0.0;  // [s]
  Pose pose;
};

struct Recording {
  std::vector<RecordedPose> poses;  // at least one; times rise strictly
  bool rotation = false;            // the orientations were recorded
};

/// Reads CSV with the columns t,x,y,z [s, m] and optionally qw,qx,qy,qz (all four or none) at any,
/// also irregular, rate. Throws CsvError that names file, line, column and remedy. `file` is used
/// only as the name in errors.
Recording read_recording(std::istream& in, const std::string& file);

/// Reads a regular file of at most 512 MiB. Throws CsvError, with `remedy` if the file does not
/// exist.
Recording read_recording(const std::filesystem::path& file, std::string_view remedy);

/// Interpolates the recorded poses around `time` [s]: the position is linear, the orientation uses
/// slerp. Before the first and after the last pose it returns that pose. `cursor` remembers the
/// last place, so a call with a rising time costs almost nothing.
Pose pose_at(const Recording& recording, double time, std::size_t& cursor) noexcept;

class ReplayDevice final : public Device {
 public:
  /// Uses the specification `spec`, but senses rotation exactly if the recording does. `leads_from`
  /// [s] since the first recorded instant: from then on the enabling switch is held; empty: never.
  ReplayDevice(Recording recording, const DeviceSpec& spec,
               std::optional<double> leads_from = std::nullopt);

  const DeviceSpec& spec() const override { return spec_; }
  /// The first call returns the first recorded instant. `ended` is true from the last recorded
  /// instant on.
  DeviceReading read(Nanoseconds now) noexcept override;
  /// The number of pairs of rows between which no hand can have moved so
  /// (core/device/possible_movement.hpp). A reading between the rows of such a pair has jumped, and
  /// so has one behind a pair that was passed over since the last reading.
  std::size_t jumps() const noexcept { return jumps_; }
  /// Returns the whole command as held, because no hand feels it.
  Command write(const Command& on_hand) noexcept override {
    return released_.load() ? Command{} : on_hand;
  }
  void release() noexcept override { released_.store(true); }

 private:
  std::atomic<bool> released_{false};
  Recording recording_;
  DeviceSpec spec_;
  std::optional<double> leads_from_;
  bool started_ = false;
  Nanoseconds start_{0};
  std::size_t cursor_ = 0;
  std::vector<bool> jumps_after_;  // of each row: the way to the next one is a jump
  std::size_t jumps_ = 0;
};

/// Opens a recording. Throws CsvError.
std::unique_ptr<Device> make_replay_device(const std::filesystem::path& file,
                                           const DeviceSpec& spec,
                                           std::optional<double> leads_from = std::nullopt);

}  // namespace feltwire
