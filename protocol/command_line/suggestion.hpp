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

/// "; write the number without its unit: 15" if a message is about a number with a unit behind it,
/// as in "Could not convert: --duration = 15ms"; else empty.
inline std::string unit_advice(std::string_view message) {
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
  return "; write the number without unit: " + std::string(word.substr(0, number));
}

/// All that helps after an error of the command line.
inline std::string advice(const CLI::Error& error, const CLI::App& app) {
  return unit_advice(error.what()) + suggestion(app);
}

}  // namespace feltwire
