#pragma once
// The folder of a flight recorder: the names of its files, and their largest number.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace feltwire {

inline constexpr const char* kFlightOption = "--flight-recorder";
// Largest number of files of a name. The oldest files are removed.
inline constexpr std::size_t kMostFlightFiles = 20;
inline constexpr std::uintmax_t kMostFlightBytes = std::uintmax_t{256} << 20;  // before a new one

/// Returns $XDG_STATE_HOME/feltwire/flights or ~/.local/state/feltwire/flights; empty: neither
/// variable is set.
std::optional<std::filesystem::path> state_flight_folder();

/// Creates the folder, for this user alone, if it is missing. Throws FileError that names it, the
/// reason and the option; also if it is there and open to other users.
void make_flight_folder(const std::filesystem::path& folder);

/// DIR/flight-TIME-NAME.mcap for a time [ns since 1970], and removes the oldest files of this name
/// until there is room for one more. Throws std::filesystem::filesystem_error.
std::filesystem::path next_flight_file(const std::filesystem::path& folder, const std::string& name,
                                       std::uint64_t time);

}  // namespace feltwire
