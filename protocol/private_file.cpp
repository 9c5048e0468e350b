#include "protocol/private_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>

namespace feltwire {

std::optional<std::string> exposure(const std::filesystem::path& file) {
  constexpr mode_t kPermissions = 0777;
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  mode_t others = S_IRWXG | S_IRWXO;
  if (status.st_uid == 0 && ::geteuid() != 0) others &= ~static_cast<mode_t>(S_IRGRP);
  if ((status.st_mode & others) == 0) return std::nullopt;
  std::array<char, 8> mode{};
  std::snprintf(mode.data(), mode.size(), "%04o", status.st_mode & kPermissions);
  return file.string() + ": is open to others than its owner (mode " + mode.data() +
         "); chmod 600 " + file.string();
}

}  // namespace feltwire
