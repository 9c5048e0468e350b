#include "core/recording/flight_files.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/file_error.hpp"
#include "core/base/folder_names.hpp"
#include "core/base/private_folder.hpp"
#include "core/base/state_folder.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t kMillisecond = 1'000'000;  // [ns]
constexpr std::string_view kBegin = "flight-", kStampLike = "20261123T070259.123Z";

/// Returns a time as text. If file names begin with this text, they sort by time.
std::string stamp(std::uint64_t time) {
  constexpr std::uint64_t kInSecond = 1000;
  const std::uint64_t milliseconds = time / kMillisecond;
  const auto since_1970 = static_cast<std::time_t>(milliseconds / kInSecond);
  std::tm parts{};
  ::gmtime_r(&since_1970, &parts);
  std::array<char, kStampLike.size() + 1> text{};
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%S", &parts);
  std::snprintf(text.data() + length, text.size() - length, ".%03uZ",
                static_cast<unsigned>(milliseconds % kInSecond));
  return text.data();
}

}  // namespace

std::optional<fs::path> state_flight_folder() {
  auto folder = user_state_folder();
  if (folder) *folder /= "flights";
  return folder;
}

void make_flight_folder(const fs::path& folder) {
  if (const std::error_code error = make_private_folder(folder))
    throw FileError(folder.string() + ": cannot be made: " + error.message() +
                    "; check the path in " + kFlightOption);
  if (const auto shared = shared_folder(folder))
    throw FileError(*shared + ", or choose another folder in " + kFlightOption +
                    ": a flight record tells what a person's hand did");
}

fs::path next_flight_file(const fs::path& folder, const std::string& name, std::uint64_t time) {
  const std::string end = '-' + name + ".mcap";
  std::vector<std::pair<fs::path, std::uintmax_t>> files;  // files and their sizes [bytes]
  std::uintmax_t bytes = 0;
  std::error_code gone;  // Another program may remove a file meanwhile.
  for (const std::string& other : names_in(folder)) {
    if (other.size() == kBegin.size() + kStampLike.size() + end.size() &&
        other.starts_with(kBegin) && other.ends_with(end)) {
      const std::uintmax_t size = fs::file_size(folder / other, gone);
      if (gone) continue;
      files.emplace_back(folder / other, size);
      bytes += size;
    }
  }
  std::ranges::sort(files);
  for (std::size_t i = 0;
       i < files.size() && (i + kMostFlightFiles <= files.size() || bytes > kMostFlightBytes);
       ++i) {
    bytes -= files[i].second;
    fs::remove(files[i].first, gone);
  }
  const auto named = [&] { return folder / (std::string(kBegin) + stamp(time) + end); };
  while (fs::exists(named())) time += kMillisecond;  // Do not overwrite an earlier file.
  return named();
}

}  // namespace feltwire
