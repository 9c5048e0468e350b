#include "core/dynamics/unpacked_files.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <system_error>

#include "core/base/file_error.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

/// Returns the number of ".." elements of a normalized path.
std::ptrdiff_t levels_up(const fs::path& name) {
  return std::count(name.begin(), name.end(), fs::path(".."));
}

fs::path make_root() {
  std::string name = (fs::canonical(fs::temp_directory_path()) / "feltwire-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw FileError(name + ": cannot be made: " + std::strerror(errno) +
                    "; name a folder that can be written to in TMPDIR");
  return name;
}

}  // namespace

UnpackedFiles::UnpackedFiles(const FileBytes& files) try : root_(make_root()), scene_(root_) {
  try {
    write(files);
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
    throw;
  }
} catch (const fs::filesystem_error& error) {
  throw FileError(std::string("the kept files cannot be written: ") + error.what());
}

UnpackedFiles::~UnpackedFiles() {
  std::error_code ignored;
  fs::remove_all(root_, ignored);
}

void UnpackedFiles::write(const FileBytes& files) {
  std::ptrdiff_t up = 0;
  for (const auto& [name, bytes] : files) {
    const fs::path path = fs::path(name).lexically_normal();
    if (path.is_absolute())
      throw FileError(name +
                      ": was named from the root of the file system, so it cannot be read from a "
                      "recording; name the scene's own file");
    up = std::max(up, levels_up(path));
  }
  for (std::ptrdiff_t i = 0; i < up; ++i) scene_ /= "in";
  fs::create_directories(scene_);
  for (const auto& [name, bytes] : files) {
    const fs::path path = (scene_ / name).lexically_normal();
    fs::create_directories(path.parent_path());
    std::ofstream out(path, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw FileError(path.string() + ": cannot be written; is the disk full?");
  }
}

}  // namespace feltwire
