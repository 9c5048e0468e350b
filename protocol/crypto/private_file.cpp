#include "protocol/crypto/private_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdio>

namespace feltwire {
namespace {

std::string mode_text(mode_t mode) {
  constexpr mode_t kPermissions = 0777;
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", mode & kPermissions);
  return text.data();
}

}  // namespace

std::optional<std::string> exposure(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  mode_t others = S_IRWXG | S_IRWXO;
  if (status.st_uid == 0 && ::geteuid() != 0) others &= ~static_cast<mode_t>(S_IRGRP);
  if ((status.st_mode & others) == 0) return std::nullopt;
  return file.string() + ": is open to others than its owner (mode " + mode_text(status.st_mode) +
         "); chmod 600 " + file.string();
}

std::optional<std::string> open_folder(const std::filesystem::path& folder) {
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0) return std::nullopt;
  if ((status.st_mode & (S_IWGRP | S_IWOTH)) == 0) return std::nullopt;
  return folder.string() + ": others than its owner may write there (mode " +
         mode_text(status.st_mode) + "); chmod 700 " + folder.string();
}

}  // namespace feltwire
