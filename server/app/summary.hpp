#pragma once
// The counters of a server as JSON, for programs to read.

#include <filesystem>
#include <string>
#include <vector>

#include "server/app/server.hpp"

namespace feltwire {

/// The counters of every scene and of the control port as JSON (docs/server.md).
std::string summary_json(const std::vector<SceneSummary>& summary, const ControlSummary& control);

/// Replaces the file in one step: readers see the whole new text or the old one. Throws
/// FileError.
void write_summary(const std::filesystem::path& file, const std::vector<SceneSummary>& summary,
                   const ControlSummary& control);

}  // namespace feltwire
