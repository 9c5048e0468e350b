#include "protocol/command_line/strict_values.hpp"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/suggestion.hpp"

namespace feltwire {
namespace {

constexpr auto kEmpty = "is empty; leave it out, or give it a value";

/// The word without leading spaces and its sign.
std::string_view digits_of(std::string_view word) {
  const std::size_t begin = word.find_first_not_of(' ');
  word.remove_prefix(begin == std::string_view::npos ? word.size() : begin);
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  return word;
}

template <class Number>
bool overflows(std::string_view word) {
  const std::size_t begin = word.find_first_not_of(" +");
  if (begin == std::string_view::npos) return false;
  Number number{};
  return std::from_chars(word.data() + begin, word.data() + word.size(), number).ec ==
         std::errc::result_out_of_range;
}

bool hexadecimal(std::string_view digits) {
  return digits.starts_with("0x") || digits.starts_with("0X");
}

/// Empty if CLI11 reads the word as it is meant, or refuses it itself.
std::string integer_complaint(const std::string& word, bool has_sign) {
  const std::string_view digits = digits_of(word);
  if (!has_sign && word.find('-') == 0) return "must be 0 or more, is " + word;
  if (hexadecimal(digits)) return "must be a decimal number, is " + word;
  if (digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9')
    return "must be a decimal number without 0 before it, is " + word;
  const bool large = has_sign ? overflows<std::int64_t>(word) : overflows<std::uint64_t>(word);
  return large ? "is too large: " + word : std::string();
}

std::string number_complaint(const std::string& word, bool has_range) {
  const std::string_view digits = digits_of(word);
  if (hexadecimal(digits)) return "must be a decimal number, is " + word;
  const bool is_nan = digits.size() >= 3 && (digits[0] == 'n' || digits[0] == 'N');
  return has_range && is_nan ? "must be a number, is " + word : std::string();
}

}  // namespace

void refuse_misread_values(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;  // a flag
    const std::string type = option->get_type_name();
    const bool has_range = type.find(" in [") != std::string::npos;
    const auto is = [&type](std::string_view kind) {
      return type.starts_with(kind) || type.starts_with("[" + std::string(kind));
    };
    const bool counts = is("UINT"), whole = counts || is("INT"), number = is("FLOAT");
    option->check([=](const std::string& word) {
      if (word.empty()) return std::string(kEmpty);
      if (whole) return integer_complaint(word, !counts);
      return number ? number_complaint(word, has_range) : std::string();
    });
  }
  for (CLI::App* command : app.get_subcommands(nullptr)) refuse_misread_values(*command);
}

void refuse_missing_values(const CLI::App& app, const std::vector<std::string>& words) {
  for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
    const std::string& word = words[i];
    if (!word.starts_with("--")) continue;
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(2, equals - 2);
    const CLI::Option* option = option_of(app, name);
    for (const CLI::App* command : app.get_subcommands(nullptr))
      if (option == nullptr) option = option_of(*command, name);
    if (option == nullptr || option->get_items_expected_min() == 0) continue;
    if (equals == word.size() - 1) throw CLI::ValidationError("--" + name, kEmpty);
    // The word after an option is its value, also where it looks like an option.
    if (equals == std::string::npos) ++i;
  }
}

void parse_arguments(CLI::App& app, int argc, const char* const* argv) {
  refuse_missing_values(app, {argv + 1, argv + argc});
  refuse_misread_values(app);
  app.parse(argc, argv);
}

std::optional<int> ends_at_arguments(CLI::App& app, int argc, const char* const* argv) {
  constexpr int kUsageError = 2;
  try {
    parse_arguments(app, argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "%s: %s; see --help\n", app.get_name().c_str(),
                 printable_error(error.what() + advice(error, app)).c_str());
    return kUsageError;
  }
}

}  // namespace feltwire
