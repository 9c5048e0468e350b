#include "core/base/private_folder.hpp"

#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstdio>

namespace feltwire {

std::error_code make_private_folder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code failed;
  if (fs::is_directory(folder, failed)) return {};
  // Drop a final slash. With it, parent_path() would return the folder itself.
  const fs::path own = folder.has_filename() ? folder : folder.parent_path();
  if (own.has_parent_path()) {
    fs::create_directories(own.parent_path(), failed);
    if (failed) return failed;
  }
  if (::mkdir(own.c_str(), S_IRWXU) == 0) return {};
  const std::error_code refused(errno, std::generic_category());
  // Another program may have made the folder in the meantime.
  return fs::is_directory(own, failed) ? std::error_code() : refused;
}

std::optional<std::string> shared_folder(const std::filesystem::path& folder) {
  constexpr mode_t kOthers = S_IRWXG | S_IRWXO, kAll = 07777;
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0 || (status.st_mode & kOthers) == 0) return std::nullopt;
  std::array<char, 8> mode{};
  std::snprintf(mode.data(), mode.size(), "%04o", status.st_mode & kAll);
  return folder.string() + ": is open to others than its owner (mode " + mode.data() +
         "); chmod 700 " + folder.string();
}

}  // namespace feltwire
