#include "client/drivers/common/shared_library.hpp"

#include <dlfcn.h>
#include <link.h>

#include <stdexcept>
#include <system_error>

namespace feltwire {
namespace {

std::string loader_error() {
  const char* text = ::dlerror();
  return text != nullptr ? text : "the loader gives no reason";
}

}  // namespace

void SharedLibrary::Close::operator()(void* handle) const noexcept { ::dlclose(handle); }

SharedLibrary::SharedLibrary(const std::filesystem::path& file)
    : file_(file), handle_(::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
  if (handle_ == nullptr) throw std::runtime_error(loader_error());
}

SharedLibrary SharedLibrary::first_of(std::span<const std::filesystem::path> files) {
  std::string errors;
  for (const std::filesystem::path& file : files) {
    try {
      return SharedLibrary(file);
    } catch (const std::runtime_error& error) {
      errors.append(errors.empty() ? "" : "; ").append(error.what());
    }
  }
  throw std::runtime_error(errors);
}

std::filesystem::path SharedLibrary::loaded_from() const {
  const link_map* map = nullptr;
  if (::dlinfo(handle_.get(), RTLD_DI_LINKMAP, &map) != 0 || map == nullptr) return file_;
  std::error_code none;
  const std::filesystem::path real = std::filesystem::canonical(map->l_name, none);
  return real.empty() ? file_ : real;
}

void* SharedLibrary::symbol(const char* name) const { return ::dlsym(handle_.get(), name); }

void* SharedLibrary::needed(const char* name) const {
  if (void* found = symbol(name)) return found;
  throw std::runtime_error(file_.string() + " has no function " + name);
}

}  // namespace feltwire
