#include "core/scene_file/parts_cache.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <system_error>

#include "core/base/captured_files.hpp"
#include "core/base/file_error.hpp"
#include "core/base/pending_file.hpp"
#include "core/base/private_folder.hpp"
#include "core/base/regular_file.hpp"
#include "core/scene_file/shown_error.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".convex";

fs::path beside(const NamedMesh& mesh) {
  return (mesh.folder / mesh.name).string() + "." + mesh.use + kEnding;
}

/// Returns the cache folder by the XDG Base Directory Specification. Returns nothing if the
/// environment gives no home folder.
std::optional<fs::path> cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/')
    return fs::path(cache) / "feltwire";
  if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/')
    return fs::path(home) / ".cache/feltwire";
  return std::nullopt;
}

/// Returns true if a file is trustworthy. In a folder that other users may write to, another user
/// may have left the file. A file of the mesh's owner is as trustworthy as the mesh.
bool is_ours(const struct stat& file, const fs::path& mesh) {
  if (file.st_uid == ::geteuid() || file.st_uid == 0) return true;
  struct stat its {};
  return ::stat(mesh.c_str(), &its) == 0 && its.st_uid == file.st_uid;
}

/// Returns the bytes of a file, or nothing if there is no file. If the file is refused, also adds a
/// remark with the reason.
std::optional<std::string> read(const fs::path& file, const fs::path& mesh,
                                std::vector<std::string>& remarks) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0) return std::nullopt;
  const auto refuse = [&](const std::string& why) {
    remarks.push_back(file.string() + ": " + why + "; it is not used");
    return std::nullopt;
  };
  if (!S_ISREG(status.st_mode)) return refuse("is not a regular file");
  if (!is_ours(status, mesh)) return refuse("belongs to somebody else");
  try {
    const FileReadingScope from_the_disk({});
    return read_regular_file(file, kMostConvexPartsFile);
  } catch (const FileError& error) {
    remarks.push_back(std::string(error.what()) + "; it is not used");
    return std::nullopt;
  }
}

class Search {
 public:
  Search(const NamedMesh& named, const MeshSurface& surface, const DecompositionOptions& options)
      : named_(named),
        surface_(surface),
        options_(options),
        key_(parts_key(surface.mesh(), options)) {}

  FoundParts run() {
    const FileReading reading = file_reading_of_this_thread;
    const std::string kept = captured_name(beside(named_));
    if (reading.given != nullptr) {
      const auto at = reading.given->find(kept);
      if (at == reading.given->end() || !take(kept, at->second)) compute();
      return std::move(found_);
    }
    const auto places = places_of_parts(named_, key_);
    if (!is_found(places)) {
      compute();
      bytes_ = convex_parts_bytes(found_.parts, key_);
      write(places);
    }
    if (reading.keep != nullptr && bytes_.size() <= kMostConvexPartsFile)
      reading.keep->insert_or_assign(kept, bytes_);
    return std::move(found_);
  }

 private:
  bool take(const fs::path& file, std::string bytes) {
    auto read = read_convex_parts(bytes, key_, surface_.mesh(), options_);
    if (const auto* why = std::get_if<std::string>(&read)) {
      found_.remarks.push_back(file.string() + ": " + *why + "; it is not used");
      return false;
    }
    found_.parts = std::get<ConvexParts>(std::move(read));
    found_.place = file.string();
    bytes_ = std::move(bytes);
    return true;
  }

  bool is_found(const std::vector<fs::path>& places) {
    for (const fs::path& place : places)
      if (auto bytes = read(place, named_.folder / named_.name, found_.remarks);
          bytes && take(place, *std::move(bytes)))
        return true;
    return false;
  }

  void compute() {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begin = Clock::now();
    found_.parts = convex_parts(surface_, options_);
    found_.computed = true;
    found_.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  }

  void write(const std::vector<fs::path>& places) {
    if (bytes_.size() > kMostConvexPartsFile) {
      found_.remarks.emplace_back("they are too large to be kept");
      return;
    }
    std::vector<std::string> failed;
    for (const fs::path& place : places) {
      const bool is_beside = place == beside(named_);
      try {
        // If this fails, replace_file() reports the error.
        if (!is_beside) make_private_folder(place.parent_path());
        replace_file(place, bytes_, is_beside ? kByUmask : std::optional(kPrivate));
        found_.place = place.string();
        return;
      } catch (const FileError& error) {
        failed.emplace_back(error.what());
      }
    }
    found_.remarks.emplace_back(
        "they are computed anew at each start; let the server write to the scene's folder, or to "
        "the folder in XDG_CACHE_HOME");
    found_.remarks.insert(found_.remarks.end(), failed.begin(), failed.end());
  }

  const NamedMesh& named_;
  const MeshSurface& surface_;
  const DecompositionOptions& options_;
  PartsKey key_;
  std::string bytes_;
  FoundParts found_;
};

}  // namespace

std::vector<fs::path> places_of_parts(const NamedMesh& mesh, const PartsKey& key) {
  std::vector<fs::path> places;
  if (!lies_outside(mesh.folder / mesh.name, mesh.folder)) places.push_back(beside(mesh));
  if (const auto folder = cache_folder()) places.push_back(*folder / (hex(key) + kEnding));
  return places;
}

FoundParts find_parts(const NamedMesh& mesh, const MeshSurface& surface,
                      const DecompositionOptions& options) {
  return Search(mesh, surface, options).run();
}

}  // namespace feltwire
