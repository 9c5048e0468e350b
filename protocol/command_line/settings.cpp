#include "protocol/command_line/settings.hpp"

#include <algorithm>
#include <stdexcept>

#include "protocol/command_line/config_file.hpp"
#include "protocol/command_line/suggestion.hpp"

namespace feltwire {
namespace {

constexpr auto kNothing = "there is nothing between two commas, or behind the last; remove a comma";

std::vector<std::string> names_of(const CLI::App& keys) {
  std::vector<std::string> names;
  for (const CLI::Option* option : keys.get_options())
    if (!option->get_lnames().empty()) names.push_back(option->get_lnames().front());
  return names;
}

[[noreturn]] void refuse(std::string_view option, const std::string& what) {
  throw std::invalid_argument(std::string(option) + ": " + what);
}

/// Throws if a setting is given twice, or has not as many numbers as it needs.
void require_counts(const CLI::App& keys, const std::vector<std::string>& settings,
                    std::string_view option) {
  std::vector<std::string> given;
  for (const std::string& setting : settings) {
    const std::string name = setting.substr(0, setting.find('='));
    if (setting.size() == name.size() + 1)
      refuse(option, setting + " has no value; write it behind the =");
    if (std::ranges::count(given, name) > 0)
      refuse(option, name + " is given twice; write it once");
    given.push_back(name);
    const CLI::Option* key = keys.get_option("--" + name);
    const auto has = std::ranges::count(setting, ',') + 1,
               needs = key->get_items_expected_min() + 0L;
    const bool number = !key->get_type_name().starts_with("TEXT");
    if (number && key->get_items_expected_max() == needs && has != needs)
      refuse(option, name + " has " + std::to_string(has) + (has == 1 ? " value" : " values") +
                         "; write " + std::to_string(needs) +
                         (needs == 1 ? "" : ", with commas between them"));
  }
}

}  // namespace

SettingsText split_settings(std::string_view text, const CLI::App& keys, SettingsBegin begins,
                            std::string_view option) {
  const std::vector<std::string> known = names_of(keys);
  SettingsText found;
  bool after_empty = false;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part(text.substr(begin, end - begin));
    const std::string name = part.substr(0, part.find('='));
    const bool named = name.size() < part.size();
    const bool setting = named && std::ranges::count(known, name) > 0;
    const bool first = found.settings.empty();
    if ((setting && after_empty) || (part.empty() && !first)) refuse(option, kNothing);
    if (named && name.empty() && (!first || begins == SettingsBegin::name))
      refuse(option, "there is no name before " + part + "; write it");
    if (begins == SettingsBegin::name && !named && std::ranges::count(known, part) > 0)
      refuse(option, part + " has no value; write " + part + "=VALUE");
    const std::string meant = named && !setting ? nearest(name, known) : std::string();
    if (setting)
      found.settings.push_back(part);
    else if (named && (!first || begins == SettingsBegin::name || !meant.empty()))
      refuse(option,
             name + " is no setting" +
                 (meant.empty() ? "; --help-all lists them" : "; did you mean " + meant + "?"));
    else
      (first ? found.begin : found.settings.back()) += (begin == 0 ? "" : ",") + part;
    after_empty = part.empty();
    begin = end + 1;
  }
  if (after_empty && !text.empty() && begins == SettingsBegin::name) refuse(option, kNothing);
  return found;
}

std::optional<std::string_view> setting_in(std::string_view text, std::string_view name) {
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(','));
    if (part.starts_with(name) && part.substr(name.size()).starts_with('='))
      return part.substr(name.size() + 1);
    text.remove_prefix(std::min(part.size() + 1, text.size()));
  }
  return {};
}

void read_settings(CLI::App& keys, const std::vector<std::string>& settings,
                   std::string_view option) {
  require_counts(keys, settings, option);
  std::vector<std::string> words;
  words.reserve(settings.size());
  for (const std::string& setting : settings) words.push_back("--" + setting);
  try {
    parse_words(keys, words);
  } catch (const CLI::ParseError& error) {
    std::string said = error.what() + advice(error, keys);
    for (const std::string& name : names_of(keys))
      if (const std::size_t at = said.find("--" + name); at != std::string::npos) said.erase(at, 2);
    refuse(option, said);
  }
}

std::string settings_help(const CLI::App& keys) {
  constexpr std::size_t kColumn = 30;  // of the descriptions, as CLI11 formats them
  std::string text = CLI::Formatter().make_groups(&keys, CLI::AppFormatMode::All);
  const std::string dashes = "\n  --";
  for (std::size_t at = text.find(dashes); at != std::string::npos; at = text.find(dashes, at)) {
    text.erase(at + 3, 2);
    // The descriptions keep their column.
    const std::size_t column = at + 1 + kColumn - 2;
    if (column < text.find('\n', at + 1) && text[column - 1] == ' ') text.insert(column, 2, ' ');
    ++at;
  }
  return text;
}

}  // namespace feltwire
