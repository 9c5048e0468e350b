#pragma once
// "Did you mean": the option that the user probably meant by an unknown word.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/number_text.hpp"

namespace feltwire {

/// The number of letters to insert, remove, replace, or swap with their neighbour in order to turn
/// one word into the other (optimal string alignment).
inline std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = last;
    last = row;
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = a[i - 1] == b[j - 1];
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

/// The nearest of the words, if at most a third of the letters differ; else empty.
inline std::string nearest(std::string_view word, const std::vector<std::string>& words) {
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& known : words)
    if (const std::size_t distance = edit_distance(word, known); distance < least) {
      least = distance;
      best = known;
    }
  return best;
}

/// For a command line with an error: "; did you mean --duration?" if a word is nearly an option or
/// a subcommand; else empty. `app` has tried to parse it.
inline std::string suggestion(const CLI::App& app) {
  const CLI::App* asked = &app;  // the subcommand whose options count
  while (!asked->get_subcommands().empty()) asked = asked->get_subcommands().front();
  std::vector<std::string> options, commands;
  for (const CLI::Option* option : asked->get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  for (const CLI::App* command : asked->get_subcommands(nullptr))
    commands.push_back(command->get_name());
  for (const std::string& word : app.remaining(true)) {
    const bool option = word.starts_with("--");
    const std::string name = word.substr(0, word.find('='));
    if (const std::string meant = nearest(name, option ? options : commands); !meant.empty())
      return "; did you mean " + meant + "?";
  }
  return {};
}

/// The unit of an option, as its description begins: "[m] Intended depth", "X,Y,Z [m] Centre".
/// Empty: it names none.
inline std::string unit_of(const CLI::Option& option) {
  const std::string& description = option.get_description();
  const auto begin = description.find('['), end = description.find(']', begin);
  const bool early = begin == 0 || begin == std::string_view("X,Y,Z ").size();
  return early && end != std::string::npos ? description.substr(begin + 1, end - begin - 1) : "";
}

/// "; write the number without unit: 15" if a message is about a number with a unit behind it, as
/// in "Could not convert: --duration = 15s"; else empty. `unit`: of the option. If the number has
/// another unit, then "; write the number without unit, in s: 0.015" for 15ms.
inline std::string unit_advice(std::string_view message, std::string_view unit = {}) {
  const std::size_t begin = message.find_last_of("= [,") + 1;
  std::string_view word = message.substr(begin);
  while (!word.empty() && (word.back() == ']' || word.back() == '\'' || word.back() == '"'))
    word.remove_suffix(1);
  const std::size_t number = length_of_number(word);
  if (number == 0 || number == word.size()) return {};
  for (const char c : word.substr(number))
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%' || c == '/' || c == '^' ||
          c == ' ' || static_cast<unsigned char>(c) >= 0x80))
      return {};
  const std::string written(word.substr(0, number));
  const std::string meant = unit.empty() ? written : number_in_unit(word, unit);
  std::string advice = "; write the number without unit";
  if (meant != written) advice += ", in " + std::string(unit);
  return meant.empty() ? advice : advice + ": " + meant;
}

/// Returns unit_advice() with the unit of the option that the error of a command line names.
inline std::string unit_advice(const CLI::Error& error, const CLI::App& app) {
  const std::string message = error.what();
  const CLI::App* asked = &app;
  while (!asked->get_subcommands().empty()) asked = asked->get_subcommands().front();
  for (const CLI::Option* option : asked->get_options())
    if (message.find(option->get_name() + " = ") != std::string::npos)
      return unit_advice(message, unit_of(*option));
  return unit_advice(message);
}

/// All that helps after an error of the command line.
inline std::string advice(const CLI::Error& error, const CLI::App& app) {
  return unit_advice(error, app) + suggestion(app);
}

}  // namespace feltwire
