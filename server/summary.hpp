#pragma once
// What a server did, for programs to read.

#include <filesystem>
#include <string>
#include <vector>

#include "server/scene_host.hpp"

namespace feltwire {

/// The counters of every scene as JSON (docs/server.md).
std::string summary_json(const std::vector<SceneSummary>& summary);

/// Writes beside the file and renames: readers see all of it, or what was there before. Throws
/// std::runtime_error naming the file.
void write_summary(const std::filesystem::path& file, const std::vector<SceneSummary>& summary);

}  // namespace feltwire
