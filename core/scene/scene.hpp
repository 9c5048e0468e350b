#pragma once
// A virtual environment: objects, and the force they answer a tool with.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/scene/json_document.hpp"

namespace feltwire {

class BodyTool;
struct BodyMemory;

/// What the objects of a scene need from whoever hosts it; what none needs is neither allocated,
/// stepped nor sent.
struct Requirements {
  bool friction = false;   // a stick point per object and tool
  bool rotation = false;   // the tool has a body: orientation and torque
  bool velocity = false;   // damping or viscous friction: a velocity estimate per tool
  double stiffness = 0.0;  // [N/m] of the stiffest material; a tool in two objects feels both
};

/// What one tool remembers of a scene between samples: one entry an object, allocated once.
using TouchMemory = std::vector<ContactMemory>;

/// Where a hand that knows nothing of the scene does well to begin: a point on a surface, world
/// frame, and the unit normal there towards the free side.
struct Start {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 normal = Vec3::UnitZ();
};

/// What a hand in the scene holds: a point, unless one of these is given.
struct HandTool {
  double radius = 0.0;                   // [m] above zero: a ball about the point
  std::shared_ptr<const BodyTool> body;  // core/tool/body_tool.hpp
};

class Scene {
 public:
  /// Throws std::invalid_argument naming the object, the field and the remedy.
  Scene(std::string name, std::vector<Object> objects, const Start& start = {});

  const std::string& name() const { return name_; }
  const std::vector<Object>& objects() const { return objects_; }
  const Requirements& requirements() const { return requirements_; }
  const Start& start() const { return start_; }

  const HandTool& tool() const { return tool_; }

  /// Puts a tool into all hands. Throws std::invalid_argument naming the field and the remedy when
  /// it does not fit what is there.
  void set_tool(HandTool tool);

  /// A memory for one tool; allocates.
  TouchMemory memory() const { return TouchMemory(objects_.size()); }

  /// The sum of what all objects answer the tool with. `memory` must come from this scene. A tool
  /// that is not finite gives zero and leaves the memory as it was. Never allocates.
  Command touch(const Tool& tool, TouchMemory& memory) const noexcept;

  /// What a tool with a body gives the hand that holds it at a pose: elastic force and torque.
  /// Precondition: tool().body is not null. Likewise for the rest.
  Command touch(const Pose& device, BodyMemory& memory) const noexcept;

 private:
  std::string name_;
  std::vector<Object> objects_;
  Requirements requirements_;
  Start start_;
  HandTool tool_;
};

/// Reads a scene file (JSON against core/scene/scene.fbs). Throws FileError.
Scene load_scene(const std::filesystem::path& file);

/// The same from text; `file` is only what errors call it.
Scene parse_scene(std::string_view json, const std::string& file);

}  // namespace feltwire
