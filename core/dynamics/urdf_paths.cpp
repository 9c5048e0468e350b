#include "core/dynamics/urdf_paths.hpp"

#include <algorithm>
#include <string_view>

namespace feltwire {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kBlanks = " \t\r\n";

std::size_t behind(std::string_view xml, std::string_view end, std::size_t at) {
  const std::size_t found = xml.find(end, at);
  return found == std::string_view::npos ? xml.size() : found + end.size();
}

/// Returns the index at which the root element begins, or npos if there is none.
std::size_t root_of(std::string_view xml) {
  std::size_t at = 0;
  while ((at = xml.find('<', at)) != std::string_view::npos) {
    const std::string_view rest = xml.substr(at);
    if (rest.starts_with("<!--"))
      at = behind(xml, "-->", at);
    else if (rest.starts_with("<?"))
      at = behind(xml, "?>", at);
    else if (rest.starts_with("<!"))
      at = behind(xml, ">", at);
    else
      return at;
  }
  return at;
}

bool is_element(std::string_view xml, std::size_t at, std::string_view name) {
  const std::size_t end = at + 1 + name.size();
  return xml.substr(at + 1, name.size()) == name && end < xml.size() &&
         (kBlanks.find(xml[end]) != std::string_view::npos || xml[end] == '>' || xml[end] == '/');
}

/// Returns the index of the next element with this name outside comments, or npos if there is none.
std::size_t find_element(std::string_view xml, std::string_view name) {
  for (std::size_t at = xml.find('<'); at < xml.size(); at = xml.find('<', at + 1)) {
    if (xml.substr(at).starts_with("<!--"))
      at = behind(xml, "-->", at) - 1;
    else if (is_element(xml, at, name))
      return at;
  }
  return std::string_view::npos;
}

constexpr std::string_view kPackage = "package://", kFile = "file://";

std::optional<fs::path> find_package_file(std::string_view path, const fs::path& folder) {
  constexpr int kMostLevels = 4;
  const std::size_t slash = path.find('/');
  if (slash == std::string_view::npos) return std::nullopt;
  const fs::path name(path.substr(0, slash)), rest(path.substr(slash + 1));
  std::error_code error;
  fs::path base = folder.empty() ? fs::path(".") : folder;
  for (int level = 0; level < kMostLevels; ++level, base /= "..")
    for (const fs::path& found : {base / name / rest, base / rest})
      if (fs::is_regular_file(found, error)) return found;
  return std::nullopt;
}

/// Replaces the value of each filename="..." by take(value).
template <class Take>
std::string with_names(const std::string& xml, Take take) {
  constexpr std::string_view kAttribute = "filename";
  std::string out;
  std::size_t copied = 0;
  for (std::size_t at = xml.find(kAttribute); at != std::string::npos;
       at = xml.find(kAttribute, at + 1)) {
    std::size_t quote = xml.find_first_not_of(kBlanks, at + kAttribute.size());
    if (quote == std::string::npos || xml[quote] != '=') continue;
    quote = xml.find_first_not_of(kBlanks, quote + 1);
    if (quote == std::string::npos || (xml[quote] != '"' && xml[quote] != '\'')) continue;
    const std::size_t end = xml.find(xml[quote], quote + 1);
    if (end == std::string::npos) break;
    out.append(xml, copied, quote + 1 - copied);
    out += take(xml.substr(quote + 1, end - quote - 1));
    copied = end;
  }
  return out.append(xml, copied);
}

}  // namespace

bool is_file_uri(std::string_view name) {
  return name.starts_with(kPackage) || name.starts_with(kFile);
}

std::optional<fs::path> file_of_uri(std::string_view uri, const fs::path& folder) {
  if (uri.starts_with(kPackage)) return find_package_file(uri.substr(kPackage.size()), folder);
  std::error_code error;
  const fs::path file(uri.starts_with(kFile) ? uri.substr(kFile.size()) : std::string_view());
  return fs::is_regular_file(file, error) ? std::optional(file) : std::nullopt;
}

bool is_urdf(std::string_view xml) {
  const std::size_t root = root_of(xml);
  return root != std::string_view::npos && is_element(xml, root, "robot");
}

std::optional<std::string> with_paths_kept(const std::string& xml, const fs::path& folder) {
  if (!is_urdf(xml)) return std::nullopt;
  for (const char* own : {"strippath", "meshdir", "assetdir"})
    if (xml.find(own) != std::string::npos) return std::nullopt;
  bool has_folder = false;
  std::string text = with_names(xml, [&](std::string name) {
    has_folder = has_folder || name.find('/') != std::string::npos;
    if (name.starts_with(kFile)) return name.substr(kFile.size());
    if (!name.starts_with(kPackage)) return name;
    const auto found = file_of_uri(name, folder);
    // Return a relative path, because MuJoCo prepends the folder of the URDF file to a name.
    return found ? found->lexically_relative(folder.empty() ? fs::path(".") : folder).string()
                 : name;
  });
  if (!has_folder) return std::nullopt;

  constexpr std::string_view kOption = " strippath=\"false\"";
  const std::size_t own = find_element(text, "mujoco");
  const std::size_t compiler =
      own == std::string::npos ? own : find_element(std::string_view(text).substr(own), "compiler");
  if (compiler != std::string::npos)
    return text.insert(own + compiler + std::string_view("<compiler").size(), kOption);
  const std::size_t root_end = text.find('>', root_of(text));
  if (root_end == std::string::npos || text[root_end - 1] == '/') return std::nullopt;
  const std::string element = "<compiler" + std::string(kOption) + "/>";
  if (own == std::string::npos)
    return text.insert(root_end + 1, "<mujoco>" + element + "</mujoco>");
  const std::size_t own_end = text.find('>', own);
  if (own_end == std::string::npos) return std::nullopt;
  if (text[own_end - 1] == '/') return text.replace(own_end - 1, 2, ">" + element + "</mujoco>");
  return text.insert(own_end + 1, element);
}

}  // namespace feltwire
