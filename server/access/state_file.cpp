#include "server/access/state_file.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include "core/base/json_document.hpp"

namespace feltwire {
namespace {

constexpr std::string_view kPart = ".part-";  // behind a file's name, while it is written

[[noreturn]] void fail(const std::filesystem::path& file) {
  throw FileError(file.string() + ": cannot be written: " + std::strerror(errno) +
                  "; check the folder and your right to write there");
}

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

PendingFile::PendingFile(std::filesystem::path file, std::string_view text, mode_t mode)
    : file_(std::move(file)), written_(file_.string() + std::string(kPart) + "XXXXXX") {
  // Over a folder nothing can be renamed: said now, not when it is too late.
  if (std::error_code failed; std::filesystem::is_directory(file_, failed)) {
    errno = EISDIR;
    fail(file_);
  }
  const int descriptor =
      ::mkostemp(written_.data(), O_CLOEXEC);  // for its owner alone, whatever comes
  if (descriptor < 0) fail(file_);
  const bool written =
      ::fchmod(descriptor, mode) == 0 && write_all(descriptor, text) && ::fsync(descriptor) == 0;
  const int reason = errno;
  ::close(descriptor);
  if (written) return;
  ::unlink(written_.c_str());
  errno = reason;
  fail(file_);
}

PendingFile::~PendingFile() {
  if (!written_.empty()) ::unlink(written_.c_str());
}

void PendingFile::put_in_place() {
  if (::rename(written_.c_str(), file_.c_str()) != 0) fail(file_);
  written_.clear();
}

void write_state(const std::filesystem::path& file, std::string_view text, mode_t mode) {
  PendingFile(file, text, mode).put_in_place();
}

/// With readdir(): where std::filesystem::directory_iterator is refused memory it may end the
/// program (libstdc++ 12).
void remove_leftovers(const std::filesystem::path& file) {
  const std::string beginning = file.filename().string() + std::string(kPart);
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  const auto close = [](DIR* open) { ::closedir(open); };
  const std::unique_ptr<DIR, decltype(close)> open(::opendir(folder.c_str()), close);
  if (open == nullptr) return;
  while (const dirent* entry = ::readdir(open.get())) {
    const std::string_view name = entry->d_name;
    constexpr std::size_t kRandom = 6;  // letters of mkostemp
    if (name.size() != beginning.size() + kRandom || !name.starts_with(beginning)) continue;
    ::unlink((folder / name).c_str());
  }
}

FileLock::FileLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kPrivate)) {
  if (descriptor_ < 0) fail(file);
  while (::flock(descriptor_, LOCK_EX) != 0) {
    if (errno == EINTR) continue;
    const int reason = errno;
    ::close(descriptor_);
    errno = reason;
    fail(file);
  }
}

FileLock::~FileLock() { ::close(descriptor_); }

}  // namespace feltwire
