#pragma once
// A folder of records that a program names by their time: BEGIN-TIME-NAME.mcap. The newest of each
// name are kept.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// The records of one kind.
struct DatedKind {
  std::string_view begin;          // of their names, as "flight-"
  const char* option;              // that names their folder
  std::string_view what;           // one of them, in errors: "a flight record"
  std::size_t most_files = 20;     // of a name; the oldest are removed
  std::uintmax_t most_bytes = ~0;  // of a name, before a new one
};

struct DatedFile {
  std::string name;
  std::uintmax_t bytes = 0;
};

/// Creates the folder, for this user alone, if it is missing. Throws FileError that names it, the
/// reason and the option; also if it is there and open to other users.
void make_dated_folder(const DatedKind& kind, const std::filesystem::path& folder);

/// The records of this kind and name in the folder, the oldest first.
std::vector<DatedFile> dated_files(const DatedKind& kind, const std::filesystem::path& folder,
                                   const std::string& name);

/// The path of a new record for a time [ns since 1970]. Removes the oldest records of this name
/// until there is room for one more. Throws std::filesystem::filesystem_error.
std::filesystem::path next_dated_file(const DatedKind& kind, const std::filesystem::path& folder,
                                      const std::string& name, std::uint64_t time);

}  // namespace feltwire
