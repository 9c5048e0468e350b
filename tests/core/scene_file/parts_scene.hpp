#pragma once
// Scenes of hollow meshes that move, in a separate folder, for tests.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/text_of.hpp"

namespace feltwire::test {

/// A profile of (r, z) [m], revolved about the z axis. It begins and ends on the axis, with the
/// solid on its left.
inline TriangleSoup revolved(const std::vector<std::pair<double, double>>& profile, int segments) {
  TriangleSoup s;
  const auto count = static_cast<std::uint32_t>(profile.size());
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    for (const auto& [r, z] : profile)
      s.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  for (int i = 0; i < segments; ++i)
    for (std::uint32_t k = 0; k + 1 < count; ++k) {
      const std::uint32_t a = static_cast<std::uint32_t>(i) * count + k;
      const std::uint32_t b = static_cast<std::uint32_t>((i + 1) % segments) * count + k;
      if (profile[k].first > 0.0) s.triangles.push_back({a, b, a + 1});
      if (profile[k + 1].first > 0.0) s.triangles.push_back({a + 1, b, b + 1});
    }
  return s;
}

inline constexpr double kCupInside = 0.034, kCupBottom = 0.006, kCupHeight = 0.08;  // [m]

/// A cup that stands on z = 0, with walls 6 mm thick.
inline TriangleSoup cup(int segments = 32) {
  constexpr double kOutside = kCupInside + kCupBottom;
  return revolved({{0.0, 0.0},
                   {kOutside, 0.0},
                   {kOutside, kCupHeight},
                   {kCupInside, kCupHeight},
                   {kCupInside, kCupBottom},
                   {0.0, kCupBottom}},
                  segments);
}

/// Writes meshes and reads scenes. The user's cache folder is inside the test's folder too.
class PartsScene : public ::testing::Test {
 protected:
  PartsScene() {
    std::filesystem::create_directories(scenes());
    ::setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
  }
  ~PartsScene() override { ::unsetenv("XDG_CACHE_HOME"); }

  std::filesystem::path scenes() const { return folder / "scenes"; }
  std::filesystem::path user_cache() const { return folder / "cache" / "feltwire"; }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(scenes() / name, std::ios::binary) << bytes;
  }
  void write(const std::string& name, const TriangleSoup& soup) const {
    write(name, obj_text(soup));
  }
  std::filesystem::path write_scene(const std::string& bodies, const std::string& objects,
                                    const std::string& more = "") const {
    write("s.json", "{ \"name\": \"s\", " + more +
                        "\"materials\": [{ \"name\": \"m\", \"stiffness\": 500 }],\n\"bodies\": [" +
                        bodies + "],\n\"objects\": [\n" + objects + "] }");
    return scenes() / "s.json";
  }
  Scene scene(const std::string& bodies, const std::string& objects,
              const std::string& more = "") const {
    return load_scene(write_scene(bodies, objects, more));
  }
  std::string error_of(const std::string& bodies, const std::string& objects) const {
    try {
      scene(bodies, objects);
    } catch (const FileError& error) {
      return error.what();
    }
    return "no error";
  }
  /// The files of a folder that end with .convex.
  static std::vector<std::filesystem::path> kept_in(const std::filesystem::path& place) {
    std::vector<std::filesystem::path> found;
    if (std::filesystem::exists(place))
      for (const auto& file : files_in(place))
        if (file.extension() == ".convex") found.push_back(file);
    return found;
  }

  TemporaryFolder folder;
};

/// An object with a mesh from a file in metres.
inline std::string mesh_text(const std::string& name, const std::string& file,
                             const std::string& in_mesh = "", const std::string& more = "") {
  return R"({ "name": ")" + name + R"(", "material": "m", "mesh": { "file": ")" + file +
         R"(", "unit": "m")" + in_mesh + " }" + more + " }";
}

}  // namespace feltwire::test
