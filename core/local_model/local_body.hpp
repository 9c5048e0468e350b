#pragma once
// Renders the local model of a tool with a body: finds the tool's balance at the client's rate.

#include <array>
#include <cstdint>

#include "core/local_model/body_model.hpp"
#include "core/local_model/prefetched_tool.hpp"

namespace feltwire {

/// The answer of a body's model at one pose of the device.
struct BodyForce {
  Command command;      // on the hand
  double weight = 0.0;  // as LocalForce::weight
  bool cut = false;     // as LocalForce::cut
};

/// Renders the newest model. The tool's pose is its own state: a new model changes the contacts,
/// and the pose changes as the tool moves on. No function allocates, throws or reads a clock.
class LocalBody {
 public:
  /// Forgets model and tool, not what is here in full.
  void clear() noexcept {
    model_.reach = last_weight_ = 0.0;
    memory_ = {};
  }

  /// Uses this tool with its solids until the next call; null: none was fetched. It must live so
  /// long.
  void use(const PrefetchedTool* whole) noexcept { whole_ = whole; }
  /// Whether the model means solids that are here.
  bool has_whole() const noexcept {
    return model_.solids != 0 && whole_ != nullptr && whole_->version == model_.solids;
  }

  /// The inertia of the tool that this side moves itself; null: that tool has no mass.
  const ToolInertia* inertia() const noexcept {
    return has_whole() && whole_->inertia.mass > 0.0 ? &whole_->inertia : nullptr;
  }

  /// Takes a new model. `ticks`: how many calls of touch() ago the device was at the model's pose,
  /// 1: the last one; 0: not known. The tool is moved by a part of the difference between the
  /// model's tool and its own tool at that time, so that the error of the planes does not
  /// accumulate where friction holds the tool. Every force of touch() is finite for all numbers in
  /// the model (PROTOCOL.md, not_finite, says which numbers a receiver accepts).
  void take(const BodyModel& model, std::uint64_t ticks = 0) noexcept;

  /// The force and torque on the hand. `age` [s]: of the model's state; moving surfaces are moved
  /// on by it. `elapsed` [s]: since the last call. A model whose solids are not here gives none. If
  /// `work` is cut off, there is none until the next model, which places the tool anew.
  BodyForce touch(const Pose& device, double age, double elapsed,
                  WorkLimit* work = nullptr) noexcept;

  const BodyModel& model() const { return model_; }
  const BodyMemory& tool() const { return memory_; }

 private:
  /// Earlier poses of the tool, and the sums of the corrections up to then.
  struct Past {
    Pose pose;
    Vec3 moved = Vec3::Zero(), turned = Vec3::Zero();
  };
  static constexpr std::size_t kRemembered = 512;  // ticks

  void correct(const BodyModel& model, std::uint64_t ticks) noexcept;

  const PrefetchedTool* whole_ = nullptr;
  BodyModel model_;
  BodyMemory memory_;
  double last_weight_ = 0.0;
  std::array<Past, kRemembered> past_{};
  std::uint64_t ticks_ = 0;                            // since the tool was placed
  Vec3 moved_ = Vec3::Zero(), turned_ = Vec3::Zero();  // [m], [rad] all corrections
};

}  // namespace feltwire
