#pragma once

#include <filesystem>
#include <string>

namespace feltwire {

/// Writes `script` to DIR/NAME.gp and runs gnuplot on it in DIR; the script names its own output.
/// The script stays beside the picture so that it can be drawn again. Throws std::runtime_error
/// with the remedy if gnuplot is missing or fails.
void plot(const std::filesystem::path& directory, const std::string& name,
          const std::string& script);

/// Draws NAME.png: two panels side by side under a title, 1300 by `height` points. `styles`:
/// gnuplot commands for both; `left`, `right`: commands that end with a panel's plot. Throws as
/// plot().
void plot_pair(const std::filesystem::path& directory, const std::string& name, int height,
               const std::string& styles, const std::string& title, const std::string& left,
               const std::string& right);

}  // namespace feltwire
