#pragma once
// A shared library that is loaded at run time: a plugin, or a device maker's own.

#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace feltwire {

class SharedLibrary {
 public:
  /// Loads a path, or a name that the system's loader looks for. Throws std::runtime_error with the
  /// loader's message.
  explicit SharedLibrary(const std::filesystem::path& file);
  /// Loads the first of these that the loader accepts. Throws std::runtime_error with the loader's
  /// message for each.
  static SharedLibrary first_of(std::span<const std::filesystem::path> files);

  const std::filesystem::path& file() const { return file_; }
  /// The file itself, where the loader found it and behind all links: its name often has a version.
  std::filesystem::path loaded_from() const;

  /// Returns the function of that name. Null if there is none.
  template <class Function>
  Function* find(const char* name) const {
    return reinterpret_cast<Function*>(symbol(name));
  }
  /// Like find(); throws std::runtime_error naming the file and the function if there is none.
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
