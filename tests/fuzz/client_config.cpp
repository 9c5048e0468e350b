// Takes arbitrary text as a configuration file. The result must be an error with its place, or
// words of a command line that set options of the program.

#include <CLI/CLI.hpp>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/file_error.hpp"
#include "protocol/command_line/config_file.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  CLI::App app;
  std::string text;
  double number = 0.0;
  bool flag = false;
  std::optional<std::array<double, 3>> center;
  std::vector<double> damping;
  std::vector<std::string> scenes;
  app.add_option("--name", text);
  app.add_option("--packet-rate", number);
  app.add_flag("--local-model,!--no-local-model", flag);
  app.add_option("--center", center)->delimiter(',');
  app.add_option("--damping", damping)->delimiter(',');
  app.add_option("--scene", scenes)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  try {
    const ConfigFile file = read_config(app, fuzz::text(data, size), "hand.json", {"config"}, {});
    const char* const program = "feltwire-client";
    const auto words = words_with_config(app, 1, &program, file, {}, false);
    for (const std::string& word : words)
      fuzz::require(word.starts_with("--"), "a file gives options alone");
    try {
      parse_words(app, words);
      fuzz::require(app.remaining_size() == 0, "every word was taken");
    } catch (const CLI::ParseError& error) {
      fuzz::require_place(file.located(error.what()), "hand.json");
    }
  } catch (const FileError& error) {
    fuzz::require_place(error.what(), "hand.json");
  }
  return 0;
}
