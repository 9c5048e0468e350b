// Takes arbitrary text as an MJCF file. The result must be an error with the file's name, or a
// scene. The scene's objects must have finite positions, and a step must be possible. A hand must
// get finite forces. MuJoCo's loader runs in a child process, so its failures, even a crash, must
// be errors here.

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/dynamics/mujoco_mjcf.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {
namespace {

constexpr int kSteps = 20;

/// A folder of this process. The destructor removes the folder.
class Folder {
 public:
  Folder()
      : path_(std::filesystem::temp_directory_path() /
              ("feltwire_fuzz_mjcf_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path_); }
  std::filesystem::path file() const { return path_ / "model.xml"; }

 private:
  std::filesystem::path path_;
};

void live(const Scene& scene) {
  World world(scene);
  TouchMemory memory = scene.memory();
  BodyContactState contacts = world.contact_state();
  for (int n = 0; n < kSteps; ++n) {
    world.step();
    for (const Object& object : world.objects())
      require(object.pose.position.allFinite() && object.pose.orientation.coeffs().allFinite(),
              "what moves is somewhere");
    const Object& touched = world.objects()[static_cast<std::size_t>(n) % world.objects().size()];
    const Command felt = world.touch(
        {touched.pose.position + Vec3(0.01 * n, 0.0, 0.001), Vec3::Zero()}, memory, contacts);
    require(felt.finite(), "every touch is answered with a finite force");
    world.push(contacts, memory, 1.0);
  }
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  const std::string text = fuzz::text(data, size);
  // Text with file names would read files of this machine. Text that multiplies bodies takes
  // minutes for a line. A height field of 65535 rows takes as long, because sanitizers disable
  // MuJoCo's memory limit.
  for (const char* word : {"file", "dir", "composite", "nrow", "&"})
    if (text.find(word) != std::string::npos) return 0;
  static const fuzz::Folder folder;
  std::ofstream(folder.file(), std::ios::binary) << text;
  try {
    std::vector<Object> objects;
    MjcfMaterials materials;
    materials.other.stiffness = 500.0;
    const auto mechanism = load_mjcf(folder.file(), materials, 1e-3, objects);
    fuzz::require(mechanism != nullptr && !objects.empty(), "a model has something to touch");
    Scene scene("mjcf", std::move(objects));
    scene.set_mechanism(mechanism);
    if (!mechanism->parts().empty()) fuzz::live(scene);
  } catch (const FileError& error) {
    fuzz::require(std::string_view(error.what()).starts_with(folder.file().string() + ":"),
                  "an error names its file");
  } catch (const std::invalid_argument&) {  // An error of a scene names the object.
  }
  return 0;
}
