// Takes arbitrary text as a scene file. The result must be an error with its place, or a scene that
// gives a tool anywhere a finite force.

#include "core/base/splitmix.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr int kTouches = 64;

/// Returns a number from -1 to 1.
double draw(std::uint64_t i) {
  return 2.0 * 0x1p-53 * static_cast<double>(splitmix::draw(1, i) >> 11) - 1.0;
}

double extent(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return s->radius;
  if (const auto* b = std::get_if<Box>(&shape)) return b->half_extents.maxCoeff();
  if (const auto* c = std::get_if<Capsule>(&shape)) return c->radius + c->half_length;
  if (const auto* c = std::get_if<Cylinder>(&shape)) return c->radius + c->half_length;
  return 1.0;
}

void require_touch(const Scene& scene, const Tool& tool, TouchMemory& memory) {
  const Command command = scene.touch(tool, memory);
  require(command.finite(), "every touch is answered with a finite force");
  require(command.torque.isZero(0.0), "a point feels no torque");
  const LocalModel model = local_model(scene, tool.position, memory);
  require(model.reach >= 0.0 && model.count >= 0 && model.count <= kMaxPatches,
          "a local model is one");
  for (const SurfacePatch& patch : model.view())
    require(patch.point.allFinite() && patch.normal.allFinite() && patch.anchor.allFinite() &&
                std::isfinite(patch.curvature) && patch.radius >= 0.0,
            "patches are finite");
}

/// Moves slowly and in jumps through each object, to its centre, and far away.
void touch_everywhere(const Scene& scene) {
  TouchMemory memory = scene.memory();
  std::uint64_t i = 0;
  const auto leap = [&](const Vec3& center, double size) {
    Tool tool;
    tool.position = center + size * Vec3(draw(i), draw(i + 1), draw(i + 2));
    tool.velocity = 10.0 * Vec3(draw(i + 3), draw(i + 4), draw(i + 5));
    i += 6;
    require_touch(scene, tool, memory);
  };
  for (const Object& object : scene.objects()) {
    const double size = extent(object.shape);
    const int touches =
        std::max(2, kTouches / static_cast<int>(std::min<std::size_t>(scene.objects().size(), 64)));
    for (int n = 0; n < touches; ++n) leap(object.pose.position, n % 2 == 0 ? size : 1.01 * size);
    require_touch(scene, {object.pose.position, Vec3::Zero()}, memory);
  }
  for (const double far : {1e-9, 1.0, 1e3, 1e9, 1e200}) leap(Vec3::Zero(), far);
  require_touch(scene, {scene.start().position, Vec3::Zero()}, memory);
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  const std::string text = fuzz::text(data, size);
  // A scene with file names would read files of this machine: a mesh, a grid, an MJCF model.
  if (text.find("file") != std::string::npos || text.find('\\') != std::string::npos) return 0;
  try {
    const Scene scene = parse_scene(text, "scene.json");
    fuzz::require((!scene.objects().empty() || !scene.guides().empty()) && !scene.name().empty(),
                  "a scene has something in it");
    fuzz::touch_everywhere(scene);
  } catch (const FileError& error) {
    fuzz::require_place(error.what(), "scene.json");
  }
  return 0;
}
