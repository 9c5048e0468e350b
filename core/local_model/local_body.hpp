#pragma once
// Renders the local model of a tool with a body: finds the tool's balance at the client's rate.

#include "core/local_model/body_model.hpp"

namespace feltwire {

/// The answer of a body's model at one pose of the device.
struct BodyForce {
  Command command;      // on the hand
  double weight = 0.0;  // as LocalForce::weight
};

/// Renders the newest model. The tool that it holds is its own: a new model changes what the tool
/// touches, and where the tool is changes as it moves on. Nothing here allocates, throws or reads a
/// clock.
class LocalBody {
 public:
  /// Forgets model and tool.
  void clear() noexcept {
    model_.reach = last_weight_ = 0.0;
    memory_ = {};
  }

  /// Takes a new model. Every force of touch() is finite, whatever numbers the model holds
  /// (PROTOCOL.md, not_finite, says what a receiver accepts).
  void take(const BodyModel& model) noexcept;

  /// The force and torque on the hand. `age` [s]: of the model's state; moving surfaces are moved
  /// on by it. `elapsed` [s]: since the last call.
  BodyForce touch(const Pose& device, double age, double elapsed) noexcept;

  const BodyModel& model() const { return model_; }
  const BodyMemory& tool() const { return memory_; }

 private:
  BodyModel model_;
  BodyMemory memory_;
  double last_weight_ = 0.0;
};

}  // namespace feltwire
