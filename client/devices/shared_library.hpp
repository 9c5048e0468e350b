#pragma once
// A shared library that is loaded while the program runs: a plugin, or a device maker's own.

#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace feltwire {

class SharedLibrary {
 public:
  /// By a path, or by a name that the system's loader looks for. Throws std::runtime_error with
  /// what the loader says.
  explicit SharedLibrary(const std::filesystem::path& file);
  /// The first of these that can be loaded. Throws std::runtime_error with what the loader says of
  /// each.
  static SharedLibrary first_of(std::span<const std::filesystem::path> files);

  const std::filesystem::path& file() const { return file_; }

  /// The function of that name; null where there is none.
  template <class Function>
  Function* find(const char* name) const {
    return reinterpret_cast<Function*>(symbol(name));
  }
  /// The same; throws std::runtime_error naming the file and the function if there is none.
  template <class Function>
  Function* get(const char* name) const {
    return reinterpret_cast<Function*>(needed(name));
  }

 private:
  struct Close {
    void operator()(void* handle) const noexcept;
  };
  void* symbol(const char* name) const;
  void* needed(const char* name) const;

  std::filesystem::path file_;
  std::unique_ptr<void, Close> handle_;
};

}  // namespace feltwire
