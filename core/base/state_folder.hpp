#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace feltwire {

/// The folder for what this user's programs keep: $XDG_STATE_HOME/feltwire or
/// ~/.local/state/feltwire. Empty: the environment has neither, or no absolute path there.
inline std::optional<std::filesystem::path> user_state_folder() {
  const auto absolute = [](const char* name) -> std::optional<std::filesystem::path> {
    const char* value = std::getenv(name);
    if (value == nullptr || *value != '/') return std::nullopt;
    return value;
  };
  if (const auto state = absolute("XDG_STATE_HOME")) return *state / "feltwire";
  if (const auto home = absolute("HOME")) return *home / ".local/state/feltwire";
  return std::nullopt;
}

}  // namespace feltwire
