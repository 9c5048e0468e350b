#include "protocol/command_line/settings.hpp"

#include <algorithm>
#include <stdexcept>

#include "protocol/command_line/config_file.hpp"
#include "protocol/command_line/suggestion.hpp"

namespace feltwire {
namespace {

std::vector<std::string> names_of(const CLI::App& keys) {
  std::vector<std::string> names;
  for (const CLI::Option* option : keys.get_options())
    if (!option->get_lnames().empty()) names.push_back(option->get_lnames().front());
  return names;
}

[[noreturn]] void refuse_setting(std::string_view name, const std::vector<std::string>& known) {
  const std::string meant = nearest(name, known);
  throw std::invalid_argument(
      std::string(name) + " is no setting" +
      (meant.empty() ? "; --help-all lists them" : "; did you mean " + meant + "?"));
}

}  // namespace

SettingsText split_settings(std::string_view text, const CLI::App& keys) {
  const std::vector<std::string> known = names_of(keys);
  SettingsText found;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part(text.substr(begin, end - begin));
    const std::size_t equals = part.find('=');
    const bool named = equals != std::string::npos;
    if (named && std::ranges::count(known, part.substr(0, equals)) > 0)
      found.settings.push_back(part);
    else if (found.settings.empty())
      found.begin += (begin == 0 ? "" : ",") + part;
    else if (named)
      refuse_setting(part.substr(0, equals), known);
    else
      found.settings.back() += "," + part;
    begin = end + 1;
  }
  return found;
}

void read_settings(CLI::App& keys, const std::vector<std::string>& settings,
                   std::string_view option) {
  std::vector<std::string> words;
  for (const std::string& setting : settings) {
    if (setting.ends_with('='))
      throw std::invalid_argument(std::string(option) + ": " + setting +
                                  " has no value; write it behind the =");
    words.push_back("--" + setting);
  }
  try {
    parse_words(keys, words);
  } catch (const CLI::ParseError& error) {
    std::string said = error.what() + advice(error, keys);
    for (const std::string& name : names_of(keys))
      if (const std::size_t at = said.find("--" + name); at != std::string::npos) said.erase(at, 2);
    throw std::invalid_argument(std::string(option) + ": " + said);
  }
}

std::string settings_help(const CLI::App& keys) {
  std::string text = CLI::Formatter().make_groups(&keys, CLI::AppFormatMode::All);
  const std::string dashes = "\n  --";
  for (std::size_t at = text.find(dashes); at != std::string::npos; at = text.find(dashes, at)) {
    text.erase(at + 3, 2);
    // The descriptions keep their column.
    const std::size_t end = text.find("  ", at + 3);
    if (end < text.find('\n', at + 1)) text.insert(end, 2, ' ');
    ++at;
  }
  return text;
}

}  // namespace feltwire
