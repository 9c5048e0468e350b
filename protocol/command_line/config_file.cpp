#include "protocol/command_line/config_file.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/base/file_error.hpp"
#include "core/base/json_document.hpp"
#include "core/base/json_outline.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "protocol/command_line/suggestion.hpp"

namespace feltwire {
namespace {

using Kind = json::Node::Kind;

bool repeats(const CLI::Option& option) {
  const bool flag = option.get_items_expected_min() == 0;
  return !flag && option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
}

/// The member of a file that sets an option.
std::string field_of(const CLI::Option& option) {
  std::string name = option.get_lnames().front();
  std::replace(name.begin(), name.end(), '-', '_');
  return name + (repeats(option) ? "s" : "");
}

class Reader {
 public:
  Reader(const CLI::App& app, std::string file, const std::vector<std::string>& command_line,
         const FileValue& file_value, const Renamed& renamed)
      : app_(app),
        file_(std::move(file)),
        command_line_(command_line),
        file_value_(file_value),
        renamed_(renamed) {}

  ConfigEntry entry(const json::Node& node) const {
    for (const CLI::Option* option : app_.get_options()) {
      if (option->get_lnames().empty() || field_of(*option) != node.key) continue;
      const std::string& name = option->get_lnames().front();
      if (std::ranges::count(command_line_, name) > 0 || option == app_.get_help_ptr() ||
          option == app_.get_help_all_ptr() || option == app_.get_version_ptr())
        fail(node, "cannot be in a file; give --" + name + " on the command line");
      return {node.key, name, node.line, words(*option, name, node)};
    }
    std::vector<std::string> known;
    for (const CLI::Option* option : app_.get_options())
      if (!option->get_lnames().empty()) known.push_back(field_of(*option));
    std::string key = node.key;
    std::replace(key.begin(), key.end(), '-', '_');
    const std::string meant = nearest(key, known);
    std::string option = key;
    std::replace(option.begin(), option.end(), '_', '-');
    const auto moved = std::ranges::find(renamed_, option, &RenamedOption::old);
    if (moved != renamed_.end()) fail(node, "is an old spelling; write " + moved->now);
    fail(node,
         "is no option of this program" +
             (meant.empty() ? std::string("; --help") +
                                  (app_.get_help_all_ptr() != nullptr ? "-all" : "") + " lists them"
                            : "; did you mean " + meant + "?"));
  }

 private:
  [[noreturn]] void fail(const json::Node& node, std::string_view key,
                         std::string_view message) const {
    throw FileError(json::error_text(file_, node.line, key, message));
  }
  [[noreturn]] void fail(const json::Node& node, std::string_view message) const {
    fail(node, node.key, message);
  }

  std::vector<std::string> words(const CLI::Option& option, const std::string& name,
                                 const json::Node& node) const {
    if (option.get_items_expected_min() == 0) return {flag(option, name, node)};
    const std::string begin = "--" + name + "=";
    if (node.kind != Kind::array) {
      if (repeats(option)) fail(node, "is a list; write [ and ] around its values");
      return {begin + value(name, node, node.key)};
    }
    if (!repeats(option) && option.get_items_expected_max() == 1)
      fail(node, "has one value; write it without brackets");
    std::vector<std::string> values;
    for (std::size_t i = 0; i < node.children.size(); ++i) {
      const std::string key = node.key + "[" + std::to_string(i) + "]";
      values.push_back(value(name, node.children[i], key));
    }
    if (repeats(option)) {
      for (std::string& one : values) one.insert(0, begin);
      return values;
    }
    if (values.empty()) fail(node, "is empty; leave it out, or write its values");
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i].find(',') != std::string::npos)
        fail(node.children[i], node.key + "[" + std::to_string(i) + "]",
             "has a comma; write one value");
    // CLI11 would take further words of the command line for the missing values.
    const std::size_t needed = static_cast<std::size_t>(option.get_items_expected_min());
    if (values.size() < needed || (values.size() > needed && option.get_items_expected_max() ==
                                                                 option.get_items_expected_min()))
      fail(node,
           "has " + std::to_string(values.size()) + " values; write " + std::to_string(needed));
    std::string joined = begin + values.front();
    for (std::size_t i = 1; i < values.size(); ++i) joined += "," + values[i];
    return {joined};
  }

  std::string flag(const CLI::Option& option, const std::string& name,
                   const json::Node& node) const {
    if (node.kind != Kind::word || (node.text != "true" && node.text != "false"))
      fail(node, "is on or off; write true or false");
    if (node.text == "true") return "--" + name;
    // --no-rehearsal stands beside --rehearsal; another flag is off unless it is given.
    return option.get_lnames().size() > 1 ? "--" + option.get_lnames()[1] : std::string();
  }

  /// Fails if this was a value of the option in earlier versions.
  void refuse_old_value(const std::string& name, const json::Node& node,
                        const std::string& key) const {
    const auto old = std::ranges::find(renamed_, name + "=" + node.text, &RenamedOption::old);
    if (old != renamed_.end())
      fail(node, key, node.text + " is an old spelling; write " + old->now);
  }

  /// `key`: of the member that has this value, or a list with it.
  std::string value(const std::string& name, const json::Node& node, const std::string& key) const {
    if (node.kind == Kind::word) refuse_old_value(name, node, key);
    if (node.kind != Kind::number && node.kind != Kind::string)
      fail(node, key, "is a number or a text; write it so");
    std::string text = node.kind == Kind::number ? node.text : text_of(node, key);
    // CLI11 would take the next word of the command line for an empty value.
    if (text.empty()) fail(node, key, "is empty; leave it out, or write its value");
    if (!file_value_) return text;
    try {
      return file_value_(name, text, std::filesystem::path(file_).parent_path());
    } catch (const std::invalid_argument& error) {
      fail(node, key, error.what());
    }
  }

  std::string text_of(const json::Node& node, const std::string& key) const {
    try {
      std::string text = nlohmann::json::parse('"' + node.text + '"').get<std::string>();
      // It would end the name of a file early.
      if (text.find('\0') != std::string::npos)
        fail(node, key, "has the character \\u0000; remove it");
      return text;
    } catch (const nlohmann::json::exception&) {
      fail(node, key, "has an escape that stands for no character; write the character itself");
    }
  }

  const CLI::App& app_;
  std::string file_;
  const std::vector<std::string>& command_line_;
  const FileValue& file_value_;
  const Renamed& renamed_;
};

/// The value of an entry as value_on_command_line() gives it.
std::string value_of(const ConfigEntry& entry) {
  if (entry.words.empty()) return {};
  const std::string& word = entry.words.front();
  const std::size_t equals = word.find('=');
  if (equals != std::string::npos) return word.substr(equals + 1);
  return word == "--" + entry.option ? "true" : "false";
}

}  // namespace

void parse_words(CLI::App& app, std::vector<std::string> words) {
  refuse_missing_values(app, words);
  refuse_misread_values(app);
  std::reverse(words.begin(), words.end());  // as CLI11 takes them
  app.parse(std::move(words));
}

std::optional<std::string> given_value(const CLI::App& app, int argc, const char* const* argv,
                                       const std::string& name, bool reads_environment) {
  if (auto value = value_on_command_line(app, argc, argv, name)) return value;
  const CLI::Option* option = option_of(app, name);
  if (!reads_environment || option == nullptr || option->get_envname().empty()) return {};
  const char* const set = std::getenv(option->get_envname().c_str());
  return set == nullptr ? std::optional<std::string>() : std::string(set);
}

std::string ConfigFile::located(const std::string& message) const {
  const ConfigEntry* first = nullptr;
  std::size_t at = std::string::npos;
  for (const ConfigEntry& entry : entries) {
    const std::string name = "--" + entry.option;
    const std::size_t found = message.find(name);
    const char after = found == std::string::npos || found + name.size() == message.size()
                           ? ' '
                           : message[found + name.size()];
    const bool whole = after != '-' && std::isalnum(static_cast<unsigned char>(after)) == 0;
    if (found >= at || !whole) continue;
    at = found;
    first = &entry;
  }
  if (first == nullptr)
    return message + (entries.empty() ? "" : " (with the options of " + path + ")");
  // "--port: 70000 is not ..." names the option a second time.
  const std::string begin = "--" + first->option + ": ";
  const std::string said = message.starts_with(begin) ? message.substr(begin.size()) : message;
  return json::error_text(path, first->line, first->field, said);
}

ConfigFile read_config(const CLI::App& app, std::string_view json,
                       const std::filesystem::path& file,
                       const std::vector<std::string>& command_line, const FileValue& file_value,
                       const Renamed& renamed) {
  ConfigFile config{file.string(), {}};
  const json::Node root = json::outline(json, config.path);
  if (root.kind != Kind::object)
    throw FileError(
        json::error_text(config.path, root.line, "", "is no object; write { \"port\": 6720 }"));
  const Reader reader(app, config.path, command_line, file_value, renamed);
  for (const json::Node& node : root.children) config.entries.push_back(reader.entry(node));
  return config;
}

FileValue files_in_folder(std::vector<std::string> options) {
  return [options = std::move(options)](std::string_view option, const std::string& value,
                                        const std::filesystem::path& folder) {
    return std::ranges::count(options, option) > 0 ? (folder / value).string() : value;
  };
}

ConfigFile given_config(const CLI::App& app, int argc, const char* const* argv,
                        std::vector<std::string> command_line, const FileValue& file_value,
                        const Renamed& renamed, bool reads_environment) {
  const auto file = given_value(app, argc, argv, "config", reads_environment);
  if (!file) return {};
  command_line.emplace_back("config");
  ConfigFile config;
  try {
    config = read_config(app, read_text(*file), *file, command_line, file_value, renamed);
  } catch (const FileError& error) {
    throw std::invalid_argument(error.what());
  }
  // The token of the environment has no option that would override the file.
  const char* const token = reads_environment ? std::getenv("FELTWIRE_TOKEN") : nullptr;
  if (token != nullptr && *token != '\0')
    std::erase_if(config.entries,
                  [](const ConfigEntry& entry) { return entry.option == "token-file"; });
  return config;
}

std::vector<std::string> words_with_config(const CLI::App& app, int argc, const char* const* argv,
                                           const ConfigFile& file, const Rivals& rivals,
                                           bool reads_environment) {
  const auto given = [&](const std::string& name) {
    return given_value(app, argc, argv, name, reads_environment);
  };
  std::vector<std::string> words;
  for (const ConfigEntry& entry : file.entries) {
    if (given(entry.option)) continue;
    const bool dropped = std::ranges::any_of(rivals, [&](const Rival& rival) {
      if (rival.dropped != entry.option) return false;
      const auto value = given(rival.given);
      if (!value || (rival.when && !rival.when(*value))) return false;
      return !rival.unless || !rival.unless(value_of(entry));
    });
    if (dropped) continue;
    for (const std::string& word : entry.words)
      if (!word.empty()) words.push_back(word);
  }
  words.insert(words.end(), argv + 1, argv + argc);
  return words;
}

}  // namespace feltwire
