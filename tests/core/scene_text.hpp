#pragma once
// Scenes as text, for tests.

#include <string>

#include "core/base/file_error.hpp"
#include "core/scene/scene.hpp"
#include "core/scene_file/load_scene.hpp"

namespace feltwire::test {

/// The loader's error for this scene.
inline std::string error_of(const std::string& scene, const std::string& file = "s.json") {
  try {
    parse_scene(scene, file);
  } catch (const FileError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace feltwire::test
