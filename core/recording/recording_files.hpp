#pragma once
// The files of a recording, and the times of its pictures.

#include <cstdint>
#include <filesystem>
#include <limits>

namespace feltwire {

/// The largest size of one file of several.
struct RecordingLimits {
  double mebibytes = std::numeric_limits<double>::infinity();
  double seconds = std::numeric_limits<double>::infinity();
  bool any() const;
  /// Whether a file of so many bytes and this duration [ns] is full.
  bool reached(std::uint64_t bytes, std::uint64_t lasts) const;
};

/// Whether the name is that of an MCAP file; all others are CSV.
bool is_mcap(const std::filesystem::path& file);
/// FILE.mcap, or with limits FILE-0001.mcap for number 1.
std::filesystem::path numbered(const std::filesystem::path& file, const RecordingLimits& limits,
                               int number);

/// 60 times a second, on a grid, so that the rate is correct unless there was a gap.
class PictureRate {
 public:
  /// Whether a picture is due now [ns]; then it sets the next one.
  bool is_due(std::uint64_t now) noexcept {
    constexpr std::uint64_t kBetween = 1'000'000'000 / 60;  // [ns]
    if (now < next_) return false;
    next_ += kBetween;
    if (next_ <= now) next_ = now + kBetween;
    return true;
  }

 private:
  std::uint64_t next_ = 0;  // [ns]
};

}  // namespace feltwire
