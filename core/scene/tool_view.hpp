#pragma once
// A scene for one tool: the objects, and the force that they command at the tool.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/contact/contact.hpp"
#include "core/guidance/guide.hpp"
#include "core/scene/broad_phase.hpp"

namespace feltwire {

class BodyTool;
struct BodyMemory;

/// The features that the objects of a scene need of a tool. A feature that no object needs is
/// neither allocated, stepped nor sent.
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
  friend class ToolView;
  std::vector<ContactMemory> contacts_;
  // For a scene of many objects: the last place of the tool, and the objects that hold it or were
  // near it. The entries of all other objects are in their initial state.
  bool tracked_ = false;
  Vec3 position_ = Vec3::Zero();  // [m]
  std::vector<std::uint32_t> live_, asked_;
};

/// The tool of a hand in the scene: a point, unless radius or body is given.
struct HandTool {
  double radius = 0.0;                   // [m] above zero: a ball about the point
  std::shared_ptr<const BodyTool> body;  // core/tool/body_tool.hpp
  std::string name = {};                 // by which hands choose it; empty: the scene's only tool
};

/// Immutable. Tools that are points or balls share one list of objects; those with a body share
/// another, in which meshes are grids.
class ToolView {
 public:
  const HandTool& tool() const { return tool_; }
  /// Static ones first, then moving ones, at their start.
  const std::vector<Object>& objects() const { return *objects_; }
  std::size_t still() const { return still_; }  // number of static objects
  const std::vector<Guide>& guides() const { return *guides_; }
  const Requirements& requirements() const { return requirements_; }
  /// Whether static objects are found by a tree. Otherwise each one is evaluated.
  bool by_tree() const { return broad_phase_.in_use(); }

  /// A mesh that became a grid, as a body touches distances, and the grid's resolution.
  struct Sampled {
    std::string object;
    double resolution = 0.0;                     // [m]
    std::size_t index = 0;                       // of the object
    std::shared_ptr<const MeshSurface> surface;  // the mesh
  };
  const std::vector<Sampled>& sampled() const { return sampled_; }
  /// The mesh whose grid is object `index`; null: it is none.
  const MeshSurface* sampled_mesh(std::size_t index) const noexcept {
    for (const Sampled& sampled : sampled_)
      if (sampled.index == index) return sampled.surface.get();
    return nullptr;
  }

  /// Makes the memory for one hand. Allocates.
  TouchMemory memory() const;

  /// The sum of the forces of all objects and guides on the tool. `memory` must come from this
  /// view. A tool whose numbers are not finite gets zero and leaves the memory unchanged. Never
  /// allocates.
  Command touch(const Tool& tool, TouchMemory& memory) const noexcept {
    Command sum = touch(tool, memory, objects_->size());
    if (!guides_->empty()) add_guides(tool, sum);
    return sum.finite() ? sum : Command{};
  }
  /// Like touch(), for the static objects only. A World (core/dynamics/world.hpp) has the places of
  /// the others, and adds the guides at the end.
  Command touch_still(const Tool& tool, TouchMemory& memory) const noexcept {
    return touch(tool, memory, still_);
  }
  /// The command for a tool with a body at a pose of the device, `elapsed` [s] after the previous
  /// call. Precondition: tool().body is not null, and nothing moves. The other arguments as above.
  Command touch(const Pose& device, const Vec3& velocity, double elapsed,
                BodyMemory& memory) const noexcept;
  /// Adds the forces of the guides. If there are objects, the guides' forces all go into the
  /// frictional part. The elastic part then comes from contacts only and keeps their normal, so a
  /// guide shares no channel of the bound with a surface (docs/bounding.md).
  void add_guides(const Tool& tool, Command& sum) const noexcept;

 private:
  friend class Scene;
  using Objects = std::shared_ptr<const std::vector<Object>>;
  using Guides = std::shared_ptr<const std::vector<Guide>>;

  /// A view for a point tool. Precondition: the objects and guides are checked.
  ToolView(Objects objects, Guides guides);
  /// This view with another tool. Throws std::invalid_argument if it does not fit the objects.
  ToolView with(HandTool tool) const;
  /// This view with objects that differ only in their materials.
  ToolView with(Objects objects) const;
  /// Only the first `count` objects are static.
  void set_still(std::size_t count);

  /// The force of the first `count` objects.
  Command touch(const Tool& tool, TouchMemory& memory, std::size_t count) const noexcept;
  /// The force of the static objects, found by the tree over them.
  Command touch_near(const Tool& tool, TouchMemory& memory) const noexcept;

  Objects objects_;
  Guides guides_;
  std::size_t still_ = 0;
  HandTool tool_;
  std::vector<Sampled> sampled_;
  Requirements requirements_;
  BroadPhase broad_phase_;  // over the static objects
};

}  // namespace feltwire
