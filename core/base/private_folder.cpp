#include "core/base/private_folder.hpp"

#include <sys/stat.h>

#include <cerrno>

namespace feltwire {

std::error_code make_private_folder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code failed;
  if (fs::is_directory(folder, failed)) return {};
  const fs::path own = folder.has_filename() ? folder : folder.parent_path();  // dir/
  if (own.has_parent_path()) {
    fs::create_directories(own.parent_path(), failed);
    if (failed) return failed;
  }
  if (::mkdir(own.c_str(), S_IRWXU) == 0) return {};
  const std::error_code refused(errno, std::generic_category());
  // Another program may have made it in the meantime.
  return fs::is_directory(own, failed) ? std::error_code() : refused;
}

}  // namespace feltwire
