#include "core/recording/dated_files.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <system_error>

#include "core/base/file_error.hpp"
#include "core/base/folder_names.hpp"
#include "core/base/private_folder.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t kMillisecond = 1'000'000;  // [ns]
constexpr std::string_view kStampLike = "20261123T070259.123Z";

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

std::string ending(const std::string& name) { return '-' + name + ".mcap"; }

}  // namespace

void make_dated_folder(const DatedKind& kind, const fs::path& folder) {
  if (const std::error_code error = make_private_folder(folder))
    throw FileError(folder.string() + ": cannot be made: " + error.message() +
                    "; check the path in " + kind.option);
  if (const auto shared = shared_folder(folder))
    throw FileError(*shared + ", or choose another folder in " + kind.option + ": " +
                    std::string(kind.what) + " tells what a person's hand did");
}

std::vector<DatedFile> dated_files(const DatedKind& kind, const fs::path& folder,
                                   const std::string& name) {
  const std::string end = ending(name);
  std::vector<DatedFile> files;
  std::error_code gone;  // Another program may remove a file meanwhile.
  for (std::string& other : names_in(folder)) {
    if (other.size() != kind.begin.size() + kStampLike.size() + end.size() ||
        !other.starts_with(kind.begin) || !other.ends_with(end))
      continue;
    const std::uintmax_t bytes = fs::file_size(folder / other, gone);
    if (!gone) files.push_back({std::move(other), bytes});
  }
  std::ranges::sort(files, {}, &DatedFile::name);
  return files;
}

fs::path next_dated_file(const DatedKind& kind, const fs::path& folder, const std::string& name,
                         std::uint64_t time) {
  const std::vector<DatedFile> files = dated_files(kind, folder, name);
  std::uintmax_t bytes = 0;
  for (const DatedFile& file : files) bytes += file.bytes;
  std::error_code gone;
  for (std::size_t i = 0;
       i < files.size() && (i + kind.most_files <= files.size() || bytes > kind.most_bytes); ++i) {
    bytes -= files[i].bytes;
    fs::remove(folder / files[i].name, gone);
  }
  const auto named = [&] {
    return folder / (std::string(kind.begin) + stamp(time) + ending(name));
  };
  while (fs::exists(named())) time += kMillisecond;  // Do not overwrite an earlier file.
  return named();
}

}  // namespace feltwire
