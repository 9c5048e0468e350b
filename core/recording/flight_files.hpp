#pragma once
// The folder of a flight recorder: the names of its files, and their largest number.

#include <cstdint>
#include <filesystem>
#include <string>

namespace feltwire {

inline constexpr const char* kFlightOption = "--flight-recorder";
inline constexpr std::size_t kMostFlightFiles = 20;  // of one name; the oldest is removed

/// Creates the folder if it is missing. Throws FileError that names it, the reason and the option.
void make_flight_folder(const std::filesystem::path& folder);

/// DIR/flight-TIME-NAME.mcap for a time [ns since 1970], and removes the oldest files of this name
/// until there is room for one more. Throws std::filesystem::filesystem_error.
std::filesystem::path next_flight_file(const std::filesystem::path& folder, const std::string& name,
                                       std::uint64_t time);

}  // namespace feltwire
