#include "core/scene_file/shown_error.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "core/base/captured_files.hpp"
#include "core/base/file_error.hpp"
#include "core/base/foreign_content.hpp"
#include "core/base/json_document.hpp"
#include "core/dynamics/refused_model.hpp"
#include "core/dynamics/urdf_paths.hpp"
#include "core/mesh/mesh_file.hpp"

namespace feltwire {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNotShown =
    ": cannot be used; what stands there is not shown, because the file lies outside of the "
    "scene's folder; copy it there to be told more";

/// Returns all values of an attribute in an XML text. A value with a character reference could be
/// any path, so it is returned as an absolute path.
std::vector<std::string> values_of(std::string_view xml, std::string_view attribute) {
  std::vector<std::string> values;
  const auto skip_blanks = [&](std::size_t at) {
    while (at < xml.size() && std::isspace(static_cast<unsigned char>(xml[at])) != 0) ++at;
    return at;
  };
  for (std::size_t at = xml.find(attribute); at != std::string_view::npos;
       at = xml.find(attribute, at + 1)) {
    std::size_t begin = skip_blanks(at + attribute.size());
    if (begin >= xml.size() || xml[begin] != '=') continue;
    begin = skip_blanks(begin + 1);
    if (begin >= xml.size() || (xml[begin] != '"' && xml[begin] != '\'')) continue;
    const std::size_t end = xml.find(xml[begin], begin + 1);
    if (end == std::string_view::npos) continue;
    const std::string value(xml.substr(begin + 1, end - begin - 1));
    values.push_back(value.find('&') == std::string::npos ? value : "/" + value);
  }
  return values;
}

/// The files that an MJCF or URDF file names, directly or through included files.
class NamedFiles {
 public:
  explicit NamedFiles(const fs::path& file) : main_(file.parent_path()) { read(file); }

  /// Returns the first named file that lies outside a folder. Searches beside the model and in the
  /// folders that the model names.
  std::optional<fs::path> outside(const fs::path& folder) const {
    if (too_many_) return main_;
    for (const auto& [name, is_plain] : names_)
      for (const fs::path& place : places_of(name))
        if (lies_outside(place, folder)) return place;
    for (const std::string& uri : uris_)
      if (auto file = file_of_uri(uri, main_); file && lies_outside(*file, folder)) return file;
    return std::nullopt;
  }

  /// Returns true if the model itself, or an included text, lies outside a folder.
  bool has_text_outside(const fs::path& folder) const {
    return too_many_ || std::ranges::any_of(texts_, [&](const fs::path& text) {
             return lies_outside(text, folder);
           });
  }

  /// Returns the first file name that MuJoCo cannot find anywhere.
  std::optional<std::string> missing() const {
    for (const auto& [name, is_plain] : names_)
      if (is_plain && !is_at(places_of(name)) && !is_at(places_of(name.filename())))
        return name.string();
    for (const std::string& uri : uris_)
      if (!file_of_uri(uri, main_) && !is_at(places_of(fs::path(uri).filename()))) return uri;
    return std::nullopt;
  }

  /// Returns the first file name that MuJoCo finds only with its folder.
  std::optional<fs::path> needs_folder() const {
    for (const auto& [name, is_plain] : names_)
      if (is_plain && name.has_parent_path() && is_at(places_of(name)) &&
          !is_at(places_of(name.filename())))
        return name;
    for (const std::string& uri : uris_)
      if (!is_at(places_of(fs::path(uri).filename()))) return uri;
    return std::nullopt;
  }

  /// Returns the path and the kind of content of the first file with the wrong content for its
  /// name.
  std::optional<std::string> foreign() const {
    for (const auto& [name, is_plain] : names_)
      for (const fs::path& place : places_of(name)) {
        std::error_code error;
        if (!fs::is_regular_file(place, error)) continue;  // Opening a pipe would block.
        std::ifstream in(place, std::ios::binary);
        std::string begin(kLooked, '\0');
        in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
        begin.resize(static_cast<std::size_t>(in.gcount()));
        if (const auto what = foreign_content(begin)) return place.string() + " " + *what;
      }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kMostNames = 10000, kLooked = 1024;

  std::vector<fs::path> places_of(const fs::path& name) const {
    std::vector<fs::path> places = {main_ / name};
    for (const fs::path& own : folders_) places.push_back(main_ / own / name);
    return places;
  }

  static bool is_at(const std::vector<fs::path>& places) {
    return std::ranges::any_of(places, [](const fs::path& place) {
      std::error_code error;
      return fs::exists(fs::symlink_status(place, error));
    });
  }

  void read(const fs::path& file) {
    std::string xml;
    try {
      xml = read_text(file);
    } catch (const FileError&) {
      return;  // An error message cannot quote a text that was not read.
    }
    const std::size_t begin = xml.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (begin == std::string::npos || xml[begin] == '<' || texts_.empty()) texts_.push_back(file);
    for (const char* attribute : {"meshdir", "texturedir", "assetdir"})
      for (const std::string& value : values_of(xml, attribute)) folders_.insert(value);
    for (const char* attribute : {"file", "filename", "fileright", "fileleft", "fileup", "filedown",
                                  "filefront", "fileback"})
      for (const std::string& value : values_of(xml, attribute)) {
        if (is_file_uri(value)) {
          uris_.insert(value);
          continue;
        }
        const bool is_plain =
            value.find('&') == std::string::npos && value.find(':') == std::string::npos;
        if (!names_.emplace(value, is_plain).second) continue;
        too_many_ =
            too_many_ || (names_.size() + uris_.size()) * (1 + folders_.size()) > kMostNames;
        if (too_many_) return;
        // Read every file, because any file may be an include with further names.
        std::error_code error;
        if (fs::is_regular_file(main_ / value, error)) read(main_ / value);
      }
  }

  fs::path main_;
  std::map<fs::path, bool> names_;  // true if MuJoCo takes the path exactly as written
  std::set<std::string> uris_;      // names that begin with package:// or file://
  std::set<fs::path> folders_;
  std::vector<fs::path> texts_;
  bool too_many_ = false;
};

}  // namespace

bool lies_outside(const fs::path& file, const fs::path& folder) {
  // A recorded file was not read from this disk, so an error reveals nothing about the disk.
  if (file_reading_of_this_thread.given != nullptr) return false;
  std::error_code error;
  const fs::path inner = fs::weakly_canonical(fs::absolute(file, error), error);
  if (error) return true;
  const fs::path outer = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
  if (error) return true;
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first != outer.end();
}

std::string shown_error(const std::string& message, const fs::path& file, const fs::path& folder) {
  const std::string name = file.string();
  if (!message.starts_with(name + ":") || !lies_outside(file, folder)) return message;
  std::size_t end = name.size() + 1;
  constexpr std::string_view kByte = " byte ";
  if (std::string_view(message).substr(end).starts_with(kByte)) end += kByte.size();
  const std::size_t digits = end;
  while (end < message.size() && std::isdigit(static_cast<unsigned char>(message[end])) != 0) ++end;
  return end == digits ? message : message.substr(0, end) + kNotShown;
}

std::string shown_mjcf_error(const FileError& error, const fs::path& file, const fs::path& folder) {
  std::string message = error.what();
  const auto* own = dynamic_cast<const RefusedModel*>(&error);
  if (file_reading_of_this_thread.given != nullptr) return message;
  const NamedFiles named(file);
  const bool shows_names = !lies_outside(file, folder) && !named.has_text_outside(folder);
  if (own != nullptr) return shows_names ? message : own->without_names();
  const std::string begin = file.string() + ": MuJoCo cannot use it: ";
  if (const auto missing = named.missing())
    return begin +
           (shows_names ? "it names '" + *missing + "', which does not exist"
                        : "a file that it names does not exist") +
           "; correct the name, or put the file there";
  if (const auto foreign = named.foreign())
    return begin + (shows_names ? *foreign : "a file that it names is not what its name says");
  const std::optional<fs::path> outside = lies_outside(file, folder) ? file : named.outside(folder);
  if (!outside) {
    const auto cut = named.needs_folder();
    if (!cut || message.find(cut->filename().string()) == std::string::npos) return message;
    return message + "; MuJoCo dropped the folder of '" + cut->string() +
           "' (strippath): write strippath=\"false\" in the file's <compiler>, or take strippath "
           "and the folders of meshes out of it";
  }
  return file.string() + ": MuJoCo cannot use it; what it says is not shown, because " +
         outside->string() + " lies outside of the scene's folder; copy it there to be told more";
}

TriangleSoup read_scene_mesh(const fs::path& folder, const std::string& name, double scale) {
  const fs::path file = folder / name;
  try {
    return read_mesh(file, scale);
  } catch (const FileError& error) {
    throw FileError(shown_error(error.what(), file, folder));
  }
}

}  // namespace feltwire
