#pragma once
// A scene: objects, guides and the tools that hands touch them with. Each tool has a view of it.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/captured_files.hpp"
#include "core/base/json_document.hpp"
#include "core/scene/tool_view.hpp"
#include "core/teleoperation/alignment.hpp"
#include "core/teleoperation/arm_control.hpp"
#include "core/teleoperation/workspace.hpp"

namespace feltwire {

class Mechanism;

/// The start of a hand that does not know the scene: a point on a surface, world frame, and the
/// unit normal there towards the free side.
struct Start {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 normal = Vec3::UnitZ();
};

/// The seat of a robot that follows a hand in this scene (docs/teleoperation.md).
struct RemoteSeat {
  std::string name = {};     // empty: the only seat of its scene
  double scale = 1.0;        // > 0 [m of the robot per m of the hand]
  double force_scale = 1.0;  // > 0 [N at the hand per N at the robot's tool]
  double speed = 0.25;       // > 0 [m/s] speed of the robot; it also limits the jumps of the hand
  double force = 40.0;       // > 0 [N] on the robot's tool, above which it holds
  Workspace workspace = {};  // of the target, in the robot's frame; at most kMostGiven walls
  // The hand's side of the walls, in the hand's frame.
  double wall_stiffness = 1000.0;  // > 0 [N/m]
  double wall_depth = 5e-3;        // > 0 [m] distance before the wall at which the spring begins
  std::optional<Alignment> aligned = {};  // empty: the robot turns by what the hand turns
  // The robot is an arm of the scene's own world, and the server moves it; empty: a robot joins.
  std::optional<ArmControl> arm = {};
};

class Scene {
 public:
  /// Throws std::invalid_argument that names the object, the field and the remedy.
  Scene(std::string name, std::vector<Object> objects, const Start& start = {},
        std::vector<Guide> guides = {});

  const std::string& name() const { return name_; }
  const Start& start() const { return start_; }
  /// For people; empty: none.
  const std::string& description() const { return description_; }
  void describe(std::string description) { description_ = std::move(description); }
  /// Warnings about its files and bodies: suspicious values that are not errors.
  const std::vector<std::string>& warnings() const { return warnings_; }
  void warn(std::vector<std::string> warnings) { warnings_ = std::move(warnings); }

  /// A line about the loading of each mesh that was cut into convex parts.
  const std::vector<std::string>& notes() const { return notes_; }
  void note(std::vector<std::string> notes) { notes_ = std::move(notes); }

  /// The moving part; null: nothing moves.
  const std::shared_ptr<const Mechanism>& mechanism() const { return mechanism_; }
  /// Precondition: made by compile() for these objects (core/dynamics/mujoco_compile.hpp).
  void set_mechanism(std::shared_ptr<const Mechanism> mechanism);

  /// Empty: no robot follows here.
  const std::vector<RemoteSeat>& seats() const { return seats_; }
  /// Precondition: check() finds no violation, there are at most kMostSeats, and all names differ.
  void set_seats(std::vector<RemoteSeat> seats) { seats_ = std::move(seats); }

  /// The files that the scene was loaded from; null: they were not kept.
  const std::shared_ptr<const CapturedFiles>& files() const { return files_; }
  void keep_files(std::shared_ptr<const CapturedFiles> files) { files_ = std::move(files); }

  /// Gives all hands this tool. For a tool with a body, meshes become grids of kMeshGridSteps steps
  /// along their longest side. Throws std::invalid_argument that names the field and the remedy if
  /// the tool does not fit the objects; the scene is then unchanged.
  void set_tool(HandTool tool);
  /// Lets each hand choose one of these tools: at least one, all names different. Throws as
  /// set_tool() does.
  void set_tools(std::vector<HandTool> tools);
  /// Gives an object another material; views() are made anew, shapes and bodies stay. Throws
  /// std::invalid_argument that names the object, the field and the remedy; the scene is then
  /// unchanged. Precondition: there is an object of this index (objects()).
  void set_material(std::size_t object, const Material& material);
  /// A view for each tool. Never empty; they live as long as the scene, also if it is moved in
  /// memory.
  const std::vector<ToolView>& views() const { return views_; }
  /// The view for a hand that asks for this tool. An empty name: the first tool. Null: there is no
  /// such tool.
  const ToolView* view(std::string_view tool) const noexcept;
  /// "tip, ball"
  std::string tool_names() const;

  // The scene for a hand that asks for no tool: the view of the first.
  operator const ToolView&() const { return views_.front(); }
  const HandTool& tool() const { return views_.front().tool(); }
  const std::vector<Object>& objects() const { return views_.front().objects(); }
  const std::vector<Guide>& guides() const { return views_.front().guides(); }
  const Requirements& requirements() const { return views_.front().requirements(); }
  TouchMemory memory() const { return views_.front().memory(); }
  Command touch(const Tool& tool, TouchMemory& memory) const noexcept {
    return views_.front().touch(tool, memory);
  }
  Command touch(const Pose& device, const Vec3& velocity, double elapsed,
                BodyMemory& memory) const noexcept {
    return views_.front().touch(device, velocity, elapsed, memory);
  }

 private:
  std::string name_, description_;
  Start start_;
  std::vector<RemoteSeat> seats_;
  std::shared_ptr<const Mechanism> mechanism_;
  std::vector<std::string> warnings_, notes_;
  std::shared_ptr<const CapturedFiles> files_;
  std::vector<ToolView> views_;
};

}  // namespace feltwire
