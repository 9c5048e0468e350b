#pragma once
// Parses command lines of feltwire-client for the tests.

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client/app/client_options.hpp"

namespace feltwire::options_test {

inline const std::string kPrint(64, 'a');  // of some certificate

/// Parses a command line without trust options.
inline std::variant<ClientOptions, int> parsed_bare(std::vector<std::string> words) {
  words.insert(words.begin(),
               {"feltwire-client", "--connect", "localhost:6720", "--scene", "room"});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  return parse_options(static_cast<int>(argv.size()), argv.data());
}

/// Parses a command line with a fingerprint and a token. The parser prints to the test's output.
inline std::variant<ClientOptions, int> parsed(std::vector<std::string> words) {
  ::setenv("FELTWIRE_TOKEN", "fw_of_a_test", 1);
  words.insert(words.begin(), {"--fingerprint", kPrint});
  return parsed_bare(std::move(words));
}

inline SafetyLimits limits(const std::vector<std::string>& words) {
  const auto options = parsed(words);
  if (const int* code = std::get_if<int>(&options)) {
    ADD_FAILURE() << "refused with " << *code;
    return {};
  }
  return std::get<ClientOptions>(options).servo.safety;
}

/// The single error line for a refused command line.
inline std::string refusal(const std::vector<std::string>& words, bool bare = false) {
  ::testing::internal::CaptureStderr();
  const auto options = bare ? parsed_bare(words) : parsed(words);
  std::string said = ::testing::internal::GetCapturedStderr();
  const int* code = std::get_if<int>(&options);
  EXPECT_TRUE(code != nullptr && *code == 2) << "not refused";
  return said;
}

}  // namespace feltwire::options_test
