#pragma once
// Third stage of a tick: the command of the virtual environment at the device's pose, from the
// newest reply, the local model, the tool with a body, and the robot.

#include <optional>

#include "client/servo/reply_intake.hpp"
#include "client/servo/rise_limit.hpp"
#include "client/servo/robot_lead.hpp"
#include "client/servo/servo_options.hpp"
#include "client/servo/servo_statistics.hpp"
#include "core/bounding/bounding.hpp"
#include "core/bounding/velocity.hpp"
#include "core/local_model/local_body.hpp"
#include "core/local_model/local_contact.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// Computes the scene's command for a tick. Allocates only when it is made.
class VirtualEnvironment {
 public:
  /// Throws std::invalid_argument if a hand leads a robot without a local model.
  VirtualEnvironment(const DeviceSpec& spec, const SessionParameters& parameters,
                     const ServoOptions& options);

  /// Renders with this scene until the next call; null: nothing was fetched. It must live so long.
  void use(const FetchedScene* fetched) noexcept;
  const FetchedScene* fetched() const noexcept { return fetched_; }

  /// Takes the newest reply, and its model. `samples`: made so far; `hold_time` [s]: of a command.
  void take(const ReplyIntake& replies, std::uint64_t samples, double hold_time,
            LocalModelCounts& counts) noexcept;

  /// Returns the command for the device at `pose`, whose bound chooses the place that the model is
  /// asked for. Sets step.local and step.normals.
  Command command(BoundingStep& step, const Bounding& bounding, const Pose& pose,
                  const ReplyIntake& replies, const SessionParameters& parameters, Nanoseconds now,
                  LocalModelCounts& counts) noexcept;
  /// No command is asked for in this tick.
  void idle() noexcept { near_ = false; }
  /// Returns step.command, which the model alone gave, with its rise limited.
  Command rise_limited(const BoundingStep& step, const ReplyIntake& replies) noexcept;
  /// The hand holds this command after the tick.
  void held(const Command& command) noexcept {
    if (!near_) rise_.given(command);
  }

  /// Forgets all surfaces until the next reply.
  void forget() noexcept;
  /// Another law bounds, from zero force on.
  void law_changed() noexcept { rise_.given({}); }

  /// The command of the last tick came from the local model alone.
  bool near() const noexcept { return near_; }
  /// The command of the last tick, of model and reply together.
  const Command& last_command() const noexcept { return command_; }
  /// Null: the hand leads no robot.
  RobotLead* robot() noexcept { return robot_ ? &*robot_ : nullptr; }
  const RobotLead* robot() const noexcept { return robot_ ? &*robot_ : nullptr; }

 private:
  double follow_point(const BoundingStep& step, const Probe& probe, const Pose& pose,
                      Nanoseconds now, Command& command, LocalModelCounts& counts) noexcept;
  double follow_body(const BoundingStep& step, const Probe& probe, const Pose& pose,
                     Nanoseconds now, Command& command, LocalModelCounts& counts) noexcept;
  WorkLimit contact_work() const noexcept;

  double period_;
  const FetchedScene* fetched_ = nullptr;
  LocalContact local_;
  LocalBody local_body_;  // for a tool with a body
  VelocityEstimate velocity_;
  RiseLimit rise_;                  // if the method shapes
  std::optional<RobotLead> robot_;  // if the hand leads a robot
  bool near_ = false;
  Vec3 model_moved_ = Vec3::Zero();  // [m] movement of the place where the model was evaluated
  Vec3 last_offset_ = Vec3::Zero();  // [m] from that place to the device
  Nanoseconds model_time_{0};        // our time of the state that the model describes
  Command command_;
};

}  // namespace feltwire
