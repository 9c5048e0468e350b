#include "core/base/text.hpp"

#include <fstream>
#include <stdexcept>

namespace feltwire {

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.flush();
  if (!out)
    throw std::runtime_error("cannot write " + file.string() +
                             "; check the folder and the space left");
}

}  // namespace feltwire
