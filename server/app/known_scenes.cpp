#include "server/app/known_scenes.hpp"

#include <algorithm>
#include <sstream>

#include "core/base/json_document.hpp"
#include "core/base/json_member.hpp"
#include "core/base/pending_file.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "server/access/security.hpp"

namespace feltwire {
namespace {

/// Returns the file with the names of the scenes, in the folder of the local user's token. Empty if
/// there is no state folder.
std::filesystem::path file_of(const ServerConfig& config) {
  const std::filesystem::path local = local_token_file(config);
  return local.empty() ? local : local.parent_path() / "scenes.txt";
}

}  // namespace

void note_scenes(const ServerConfig& config, const std::vector<std::string>& names) noexcept {
  try {
    const std::filesystem::path file = file_of(config);
    if (file.empty()) return;
    std::string text;
    for (const std::string& name : names) text += name + '\n';
    replace_file(file, text, kPrivate);
  } catch (const std::exception&) {
    return;  // a failure is no error: only a warning of `token add` needs the file
  }
}

std::vector<std::string> known_scenes(const ServerConfig& config) {
  std::vector<std::string> names;
  try {
    for (const auto& scene : config.scenes)
      if (const auto name = json_text_member(read_text(scene), "name")) names.push_back(*name);
    if (!config.scenes.empty()) return names;
    const std::filesystem::path file = file_of(config);
    if (file.empty()) return names;
    std::istringstream lines(read_text(file));
    for (std::string line; std::getline(lines, line);) names.push_back(line);
  } catch (const std::exception&) {
    names.clear();  // the server reports errors in its files itself
  }
  return names;
}

std::optional<std::string> unknown_scene(const std::string& scene,
                                         const std::vector<std::string>& known) {
  if (scene == "*" || known.empty() || std::ranges::find(known, scene) != known.end())
    return std::nullopt;
  std::string all;
  for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
  const std::string meant = nearest(scene, known);
  return "this server has no scene '" + scene + "'" +
         (meant.empty() ? "." : "; did you mean " + meant + "?") + " Its scenes are: " + all +
         ". The token opens nothing until one has this name";
}

}  // namespace feltwire
