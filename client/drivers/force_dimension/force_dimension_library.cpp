#include "client/drivers/force_dimension/force_dimension_library.hpp"

#include <sys/utsname.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/base/folder_names.hpp"

namespace feltwire::drd {
namespace {

namespace fs = std::filesystem;

/// Returns the library files to try, in this order. libdrd comes before libdhd because it contains
/// all of libdhd.
std::vector<fs::path> libraries() {
  std::vector<fs::path> folders;
  utsname machine{};
  ::uname(&machine);
  for (const char* variable : {"FDSDK", "FORCEDIM_SDK"})
    if (const char* root = std::getenv(variable))
      folders.push_back(fs::path(root) / "lib/release" /
                        ("lin-" + std::string(machine.machine) + "-gcc"));
  if (const char* home = std::getenv("HOME")) folders.push_back(fs::path(home) / ".local/lib");
  folders.emplace_back("/usr/local/lib");
  std::vector<fs::path> files;
  for (const std::string name : {"libdrd.so", "libdhd.so"}) {
    for (const fs::path& folder : folders) {
      std::vector<fs::path> found;
      for (const std::string& other : names_in(folder))
        if (other.starts_with(name)) found.push_back(folder / other);
      std::sort(found.rbegin(), found.rend());
      // Add a file that does not exist, so that the loader's error message names the folder.
      if (found.empty()) found.push_back(folder / name);
      files.insert(files.end(), found.begin(), found.end());
    }
    files.emplace_back(name);  // searched by the dynamic loader
    files.emplace_back(name + ".3");
  }
  return files;
}

}  // namespace

void refuse(const std::string& why) { throw std::runtime_error("forcedimension: " + why); }

SharedLibrary load() {
  const std::vector<fs::path> files = libraries();
  try {
    SharedLibrary library = SharedLibrary::first_of(files);
    [[maybe_unused]] const Calls all(library);
    return library;
  } catch (const std::runtime_error& error) {
    refuse(std::string("the maker's library cannot be used: ") + error.what() +
           "; install the Force Dimension SDK 3.14 or newer and set FDSDK to its folder. It needs "
           "libusb-1.0-0");
  }
}

}  // namespace feltwire::drd
