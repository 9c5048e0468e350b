#pragma once
// A recorded movement as a device: it repeats the movement for every force.

#include <atomic>
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "client/devices/device.hpp"

namespace feltwire {

struct RecordedPose {
  double time = 0.0;  // [s]
  Pose pose;
};

struct Recording {
  std::vector<RecordedPose> poses;  // at least one, times strictly rising
  bool rotation = false;            // the orientations were recorded
};

/// Reads CSV with the columns t,x,y,z [s, m] and optionally qw,qx,qy,qz (all four or none) at any,
/// also irregular, rate. Throws CsvError naming file, line, column and remedy; `file` is only what
/// errors call it.
Recording read_recording(std::istream& in, const std::string& file);

/// From a regular file of at most 512 MiB; throws CsvError, with `remedy` where it is not there.
Recording read_recording(const std::filesystem::path& file, std::string_view remedy);

/// Position linear, orientation by slerp between the recorded poses around `time` [s]; before the
/// first and after the last these themselves. `cursor` remembers where the last call was, so that
/// rising times cost nothing.
Pose pose_at(const Recording& recording, double time, std::size_t& cursor) noexcept;

class ReplayDevice final : public Device {
 public:
  /// Behaves as `spec` says, but senses rotation exactly when the recording does.
  ReplayDevice(Recording recording, const DeviceSpec& spec);

  const DeviceSpec& spec() const override { return spec_; }
  /// The first call is the first recorded instant; `ended` from the last recorded instant on.
  DeviceReading read(Nanoseconds now) noexcept override;
  /// Returns the whole command as held: no hand feels it.
  Command write(const Command& on_hand) noexcept override {
    return released_.load() ? Command{} : on_hand;
  }
  void release() noexcept override { released_.store(true); }

 private:
  std::atomic<bool> released_{false};
  Recording recording_;
  DeviceSpec spec_;
  bool started_ = false;
  Nanoseconds start_{0};
  std::size_t cursor_ = 0;
};

/// From a file; throws CsvError.
std::unique_ptr<Device> make_replay_device(const std::filesystem::path& file,
                                           const DeviceSpec& spec);

}  // namespace feltwire
