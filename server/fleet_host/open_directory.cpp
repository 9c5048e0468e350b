#include "server/fleet_host/open_directory.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>
#include <string>

#include "server/fleet/memory_directory.hpp"

namespace feltwire {

std::shared_ptr<Directory> memory_directory() {
  static const auto directory = std::make_shared<MemoryDirectory>();
  return directory;
}

std::shared_ptr<Directory> open_nats_directory(const NatsOptions& options) {
  // A file of the program's own installation: never one of this name from elsewhere.
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
  const std::filesystem::path module = program.parent_path() / "../lib/feltwire/feltwire-nats.so";
  // RTLD_NODELETE: threads of the client library of NATS may outlive the directory.
  void* const loaded = ::dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (loaded == nullptr) {
    const char* const why = ::dlerror();
    throw std::runtime_error(std::string("--fleet nats://: ") +
                             (why != nullptr ? why : module.c_str()) +
                             "; install the package feltwire-fleet, or build with libnats-dev and "
                             "install the component fleet");
  }
  using Open = Directory* (*)(const NatsOptions*);
  auto* const open = reinterpret_cast<Open>(::dlsym(loaded, "feltwire_open_nats_directory"));
  if (open == nullptr)
    throw std::runtime_error(module.string() + " is of another version of feltwire-server");
  return std::shared_ptr<Directory>(open(&options));
}

}  // namespace feltwire
