#include "core/recording/recording_files.hpp"

#include <cmath>
#include <string>

namespace feltwire {

bool RecordingLimits::any() const { return std::isfinite(mebibytes) || std::isfinite(seconds); }

bool RecordingLimits::reached(std::uint64_t bytes, std::uint64_t lasts) const {
  constexpr double kMebibyte = 1 << 20, kSecond = 1e9;
  return static_cast<double>(bytes) >= mebibytes * kMebibyte ||
         static_cast<double>(lasts) >= seconds * kSecond;
}

bool is_mcap(const std::filesystem::path& file) { return file.extension() == ".mcap"; }

std::filesystem::path numbered(const std::filesystem::path& file, const RecordingLimits& limits,
                               int number) {
  if (!limits.any()) return file;
  constexpr std::size_t kDigits = 4;
  std::string digits = std::to_string(number);
  if (digits.size() < kDigits) digits.insert(0, kDigits - digits.size(), '0');
  return file.parent_path() / (file.stem().string() + '-' + digits + file.extension().string());
}

}  // namespace feltwire
