#pragma once
// A scene: objects, guides and tools, and the force that they command at a tool.

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

/// The features that the objects of a scene need. A feature that no object needs is neither
/// allocated, stepped nor sent.
struct Requirements {
  bool friction = false;  // a stick point per object and tool
  bool rotation = false;  // the tool has a body: orientation and torque
  bool velocity = false;  // damping or viscous friction: a velocity estimate per tool
  bool guides = false;    // forces without a surface
  double stiffness =
      0.0;  // [N/m] of the stiffest material or guide; a tool in two objects feels both
};

/// The contact state of one tool in a scene, kept between samples. One entry for each object,
/// allocated once.
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
  // In a scene of many objects: where the tool was, and the objects that hold it or were near it.
  // The entries of all other objects are in their initial state.
  bool tracked_ = false;
  Vec3 position_ = Vec3::Zero();  // [m]
  std::vector<std::uint32_t> live_, asked_;
};

/// Where a hand that does not know the scene should begin: a point on a surface, world frame, and
/// the unit normal there towards the free side.
struct Start {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 normal = Vec3::UnitZ();
};

/// The tool of a hand in the scene: a point, unless radius or body is given.
struct HandTool {
  double radius = 0.0;                   // [m] above zero: a ball about the point
  std::shared_ptr<const BodyTool> body;  // core/tool/body_tool.hpp
  std::string name = {};                 // by which hands choose it; empty: the scene's only tool
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
  /// Warnings about its files and bodies: suspicious values that are not errors.
  const std::vector<std::string>& warnings() const { return warnings_; }
  void warn(std::vector<std::string> warnings) { warnings_ = std::move(warnings); }

  /// The tool of the hands that feel this scene.
  const HandTool& tool() const { return tool_; }
  /// Whether static objects are found by a tree. Else each one is asked.
  bool by_tree() const { return broad_phase_.in_use(); }

  /// Gives all hands this tool. For a tool with a body, meshes become grids of kMeshGridSteps steps
  /// along their longest side. Throws std::invalid_argument that names the field and the remedy if
  /// the tool does not fit the objects; the scene is then unchanged.
  void set_tool(HandTool tool);
  /// Lets each hand choose one of these tools: at least one, all names different. This object is
  /// then the scene for hands that hold the first tool. Throws as set_tool() does.
  void set_tools(std::vector<HandTool> tools);
  /// The scene for hands that hold the other tools. Triangles and grids are shared.
  const std::vector<std::shared_ptr<const Scene>>& others() const { return others_; }
  /// The scene for a hand that asks for this tool; an empty name stands for the first. Null: there
  /// is no such tool. Lives as long as this.
  const Scene* held(std::string_view tool) const noexcept;

  /// A mesh that became a grid, and the grid's resolution.
  struct Sampled {
    std::string object;
    double resolution = 0.0;  // [m]
  };
  const std::vector<Sampled>& sampled() const { return sampled_; }
  static constexpr double kMeshGridSteps = 128.0;

  /// Makes the memory for one tool. Allocates.
  TouchMemory memory() const;

  /// The sum of the forces of all objects and guides on the tool. `memory` must come from this
  /// scene. A tool whose numbers are not finite gets zero and leaves the memory unchanged. Never
  /// allocates.
  Command touch(const Tool& tool, TouchMemory& memory) const noexcept {
    Command sum = touch(tool, memory, objects_.size());
    if (!guides_.empty()) add_guides(tool, sum);
    return sum.finite() ? sum : Command{};
  }
  /// The same for the static objects only. A World (core/dynamics/world.hpp) knows where the others
  /// are, and adds the guides at the end.
  Command touch_still(const Tool& tool, TouchMemory& memory) const noexcept {
    return touch(tool, memory, still_);
  }

  /// The moving part; null: nothing moves.
  const std::shared_ptr<const Mechanism>& mechanism() const { return mechanism_; }
  /// Precondition: made by compile() for these objects (core/scene/mechanism.hpp).
  void set_mechanism(std::shared_ptr<const Mechanism> mechanism);

  /// The command for a tool with a body at a pose of the device, `elapsed` [s] after the previous
  /// call. Precondition: tool().body is not null, and nothing moves. The other arguments as above.
  Command touch(const Pose& device, const Vec3& velocity, double elapsed,
                BodyMemory& memory) const noexcept;
  /// Adds the forces of the guides. If there are objects, the guides' forces all go into the
  /// frictional part. The elastic part then comes from contacts only and keeps their normal, so a
  /// guide shares no channel of the bound with a surface (docs/bounding.md).
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
