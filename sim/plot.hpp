#pragma once

#include <filesystem>
#include <string>

namespace feltwire {

/// Writes `script` to DIR/NAME.gp and runs gnuplot on it in DIR; the script names its own output.
/// The script stays beside the picture so that it can be drawn again. Throws std::runtime_error
/// with the remedy when gnuplot is missing or fails.
void plot(const std::filesystem::path& directory, const std::string& name,
          const std::string& script);

}  // namespace feltwire
