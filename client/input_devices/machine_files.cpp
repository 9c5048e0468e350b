#include "client/input_devices/machine_files.hpp"

#include <algorithm>
#include <fstream>

#include "core/base/folder_names.hpp"

namespace feltwire {

namespace fs = std::filesystem;

std::string line_of(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const std::string& name : names_in(folder)) found.push_back(folder / name);
  std::sort(found.begin(), found.end());
  return found;
}

std::string rule_to_paste(const std::string& rule) {
  return "write into /etc/udev/rules.d/70-feltwire.rules the line  " + rule +
         "  then run  udevadm control --reload  as root, and plug it in anew";
}

}  // namespace feltwire
