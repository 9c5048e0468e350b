#include "core/recording/flight_files.hpp"

#include "core/base/state_folder.hpp"
#include "core/recording/dated_files.hpp"

namespace feltwire {
namespace {

constexpr DatedKind kFlights{.begin = "flight-",
                             .option = kFlightOption,
                             .what = "a flight record",
                             .most_files = kMostFlightFiles,
                             .most_bytes = kMostFlightBytes};

}  // namespace

std::optional<std::filesystem::path> state_flight_folder() {
  auto folder = user_state_folder();
  if (folder) *folder /= "flights";
  return folder;
}

void make_flight_folder(const std::filesystem::path& folder) {
  make_dated_folder(kFlights, folder);
}

std::filesystem::path next_flight_file(const std::filesystem::path& folder, const std::string& name,
                                       std::uint64_t time) {
  return next_dated_file(kFlights, folder, name, time);
}

}  // namespace feltwire
