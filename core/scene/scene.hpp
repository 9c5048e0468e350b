#pragma once
// A virtual environment: objects, and the force they answer a tool with.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/guidance/guide.hpp"
#include "core/scene/json_document.hpp"

namespace feltwire {

class Mechanism;

/// What the objects of a scene need from whoever hosts it; what none needs is neither allocated,
/// stepped nor sent.
struct Requirements {
  bool friction = false;  // a stick point per object and tool
  bool velocity = false;  // damping or viscous friction: a velocity estimate per tool
  bool guides = false;    // forces without a surface
  double stiffness =
      0.0;  // [N/m] of the stiffest material or guide; a tool in two objects feels both
};

/// What one tool remembers of a scene between samples: one entry an object, allocated once.
using TouchMemory = std::vector<ContactMemory>;

/// Where a hand that knows nothing of the scene does well to begin: a point on a surface, world
/// frame, and the unit normal there towards the free side.
struct Start {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 normal = Vec3::UnitZ();
};

class Scene {
 public:
  /// Throws std::invalid_argument naming the object, the field and the remedy.
  Scene(std::string name, std::vector<Object> objects, const Start& start = {},
        std::vector<Guide> guides = {});

  const std::string& name() const { return name_; }
  const std::vector<Object>& objects() const { return objects_; }
  const std::vector<Guide>& guides() const { return guides_; }
  const Requirements& requirements() const { return requirements_; }
  const Start& start() const { return start_; }

  /// A memory for one tool; allocates.
  TouchMemory memory() const { return TouchMemory(objects_.size()); }

  /// The sum of what all objects and guides answer the tool with. `memory` must come from this
  /// scene. A tool that is not finite gives zero and leaves the memory as it was. Never allocates.
  Command touch(const Tool& tool, TouchMemory& memory) const noexcept {
    return touch(tool, memory, objects_.size());
  }
  /// The same without the objects that move: a World (core/scene/world.hpp) knows where these are.
  Command touch_still(const Tool& tool, TouchMemory& memory) const noexcept {
    return touch(tool, memory, still_);
  }

  /// What moves, and how; null: nothing does.
  const std::shared_ptr<const Mechanism>& mechanism() const { return mechanism_; }
  /// Precondition: made by compile() for these objects (core/scene/mechanism.hpp).
  void set_mechanism(std::shared_ptr<const Mechanism> mechanism);

 private:
  /// Of the first `count` objects.
  Command touch(const Tool& tool, TouchMemory& memory, std::size_t count) const noexcept;

  std::string name_;
  std::vector<Object> objects_;
  std::vector<Guide> guides_;
  Requirements requirements_;
  Start start_;
  std::shared_ptr<const Mechanism> mechanism_;
  std::size_t still_ = 0;  // objects that stand; those that move come behind them
};

/// Reads a scene file (JSON against core/scene/scene.fbs). Throws FileError.
Scene load_scene(const std::filesystem::path& file);

/// The same from text; `file` is only what errors call it.
Scene parse_scene(std::string_view json, const std::string& file);

}  // namespace feltwire
