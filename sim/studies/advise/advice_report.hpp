#pragma once
// The advice as a page, as JSON, as a picture, and as configuration files.

#include <filesystem>
#include <string>

#include "sim/studies/advise/advice.hpp"

namespace feltwire::advise {

/// The names under which the device and the scene are found again.
struct Sources {
  std::string device;  // a built-in name, or the path of a specification (.json)
  std::filesystem::path scene;
};

/// A page for people.
std::string advice_text(const Question& question, const Sources& sources, const Advice& advice);
/// Its numbers as JSON.
std::string advice_json(const Question& question, const Sources& sources, const Advice& advice);
/// For feltwire-client --config and feltwire-server --config. A path is written as an absolute one.
std::string client_config(const Sources& sources, const Advice& advice);
std::string server_config(const Question& question, const Sources& sources, const Advice& advice);

/// Writes advice.txt, advice.json, advice.png, client.json and server.json to `directory`
/// (created). Throws std::runtime_error.
void write_advice(const std::filesystem::path& directory, const Question& question,
                  const Sources& sources, const Advice& advice);

}  // namespace feltwire::advise
