#pragma once
// A virtual environment: objects, and the force they answer a tool with.

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/json_document.hpp"
#include "core/contact/contact.hpp"
#include "core/guidance/guide.hpp"
#include "core/scene/broad_phase.hpp"

namespace feltwire {

class Mechanism;
class BodyTool;
struct BodyMemory;

/// The features that the objects of a scene need from its host. A feature that none needs is
/// neither allocated, stepped nor sent.
struct Requirements {
  bool friction = false;  // a stick point per object and tool
  bool rotation = false;  // the tool has a body: orientation and torque
  bool velocity = false;  // damping or viscous friction: a velocity estimate per tool
  bool guides = false;    // forces without a surface
  double stiffness =
      0.0;  // [N/m] of the stiffest material or guide; a tool in two objects feels both
};

/// The memory of one tool for a scene, between samples: one entry an object, allocated once.
class TouchMemory {
 public:
  TouchMemory() = default;
  explicit TouchMemory(std::size_t objects) : contacts_(objects) {}

  std::size_t size() const { return contacts_.size(); }
  ContactMemory& operator[](std::size_t i) { return contacts_[i]; }
  const ContactMemory& operator[](std::size_t i) const { return contacts_[i]; }
  auto begin() { return contacts_.begin(); }
  auto end() { return contacts_.end(); }
  auto begin() const { return contacts_.begin(); }
  auto end() const { return contacts_.end(); }

 private:
  friend class Scene;
  std::vector<ContactMemory> contacts_;
  // Of a scene of many objects: where the tool was, and the objects that hold it or that it was
  // near to; what is in no list is as new.
  bool tracked_ = false;
  Vec3 position_ = Vec3::Zero();  // [m]
  std::vector<std::uint32_t> live_, asked_;
};

/// Where a hand that knows nothing of the scene does well to begin: a point on a surface, world
/// frame, and the unit normal there towards the free side.
struct Start {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 normal = Vec3::UnitZ();
};

/// The tool of a hand in the scene: a point, unless radius or body is given.
struct HandTool {
  double radius = 0.0;                   // [m] above zero: a ball about the point
  std::shared_ptr<const BodyTool> body;  // core/tool/body_tool.hpp
  std::string name = {};                 // what hands ask for; empty: the scene's only one
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
  /// Warnings about its files and its bodies: strange, but no error.
  const std::vector<std::string>& warnings() const { return warnings_; }
  void warn(std::vector<std::string> warnings) { warnings_ = std::move(warnings); }

  /// The tool of the hands that feel this scene.
  const HandTool& tool() const { return tool_; }
  /// The objects that stand are found by a tree; else each is asked.
  bool by_tree() const { return broad_phase_.in_use(); }

  /// Puts a tool into all hands. For one with a body, meshes become grids: kMeshGridSteps along
  /// their longest side. Throws std::invalid_argument naming the field and the remedy when it does
  /// not fit what is there, and then changes nothing.
  void set_tool(HandTool tool);
  /// Lets each hand choose one of several, at least one, each of another name. This is then the
  /// scene for hands that hold the first. Likewise.
  void set_tools(std::vector<HandTool> tools);
  /// The same scene for hands that hold the other tools; its triangles and grids are shared.
  const std::vector<std::shared_ptr<const Scene>>& others() const { return others_; }
  /// The scene for a hand that asks for this tool; empty: for none, which is the first. Null: it
  /// has no such tool. Lives as long as this.
  const Scene* held(std::string_view tool) const noexcept;

  /// A mesh that became a grid, and how fine.
  struct Sampled {
    std::string object;
    double resolution = 0.0;  // [m]
  };
  const std::vector<Sampled>& sampled() const { return sampled_; }
  static constexpr double kMeshGridSteps = 128.0;

  /// A memory for one tool; allocates.
  TouchMemory memory() const;

  /// The sum of what all objects and guides answer the tool with. `memory` must come from this
  /// scene. A tool that is not finite gives zero and leaves the memory as it was. Never allocates.
  Command touch(const Tool& tool, TouchMemory& memory) const noexcept {
    Command sum = touch(tool, memory, objects_.size());
    if (!guides_.empty()) add_guides(tool, sum);
    return sum.finite() ? sum : Command{};
  }
  /// The same of the objects that stand alone: a World (core/dynamics/world.hpp) knows where the
  /// others are, and adds the guides to the sum of all.
  Command touch_still(const Tool& tool, TouchMemory& memory) const noexcept {
    return touch(tool, memory, still_);
  }

  /// The moving part; null: nothing moves.
  const std::shared_ptr<const Mechanism>& mechanism() const { return mechanism_; }
  /// Precondition: made by compile() for these objects (core/scene/mechanism.hpp).
  void set_mechanism(std::shared_ptr<const Mechanism> mechanism);

  /// The command of a tool with a body at a pose of the device, `elapsed` [s] after the one before.
  /// Precondition: tool().body is not null, and nothing moves. The other arguments as above.
  Command touch(const Pose& device, const Vec3& velocity, double elapsed,
                BodyMemory& memory) const noexcept;
  /// Adds what the guides do. Beside objects all of it is frictional: the elastic part is then the
  /// contacts' alone and keeps their normal, so that a guide shares no channel of the bound with
  /// the surface (docs/bounding.md).
  void add_guides(const Tool& tool, Command& sum) const noexcept;

 private:
  /// Of the first `count` objects.
  Command touch(const Tool& tool, TouchMemory& memory, std::size_t count) const noexcept;
  void find_by_tree();
  /// Of the objects that stand, by the tree over them.
  Command touch_near(const Tool& tool, TouchMemory& memory) const noexcept;

  std::string name_;
  std::vector<Object> objects_;
  BroadPhase broad_phase_;  // over these
  std::vector<Guide> guides_;
  Requirements requirements_;
  Start start_;
  std::shared_ptr<const Mechanism> mechanism_;
  std::size_t still_ = 0;  // objects that stand; those that move come behind them
  std::vector<std::string> warnings_;
  HandTool tool_;
  std::vector<Sampled> sampled_;
  std::vector<std::shared_ptr<const Scene>> others_;
};

}  // namespace feltwire
