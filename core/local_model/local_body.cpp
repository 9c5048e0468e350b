#include "core/local_model/local_body.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/local_model/share_within.hpp"

namespace feltwire {
namespace {

double weight_at(const BodyModel& model, const Pose& tool) noexcept {
  const double way = length(Vec3(tool.position - model.tool.position));
  const double angle = length(rotation_between(model.tool.orientation, tool.orientation));
  return share_within(way / model.reach + angle / model.turn, 1.0);
}

}  // namespace

void LocalBody::take(const BodyModel& model, std::uint64_t ticks) noexcept {
  if (last_weight_ > 0.0 && memory_.placed && model.scene == model_.scene) {
    correct(model, ticks);
  } else {
    memory_ = {};
    memory_.placed = model.reach > 0.0;
    memory_.pose = model.tool;
    memory_.slipping = model.slipping;
    ticks_ = 0;
    moved_.setZero();
    turned_.setZero();
  }
  model_ = model;
}

/// Moves the tool towards its pose in the server's model. The model has the pose of one round trip
/// ago, without the corrections since then. So subtract these corrections, to correct each
/// difference only once (Smith predictor, 1957).
void LocalBody::correct(const BodyModel& model, std::uint64_t ticks) noexcept {
  constexpr double kPart = 0.1;  // share of the difference that one call corrects
  if (ticks == 0 || ticks > ticks_ || ticks > kRemembered) return;
  const Past& past = past_[(ticks_ - ticks) % kRemembered];
  const Vec3 off = kPart * (model.tool.position - past.pose.position - (moved_ - past.moved));
  const Vec3 twisted = kPart * (rotation_between(past.pose.orientation, model.tool.orientation) -
                                (turned_ - past.turned));
  if (!off.allFinite() || !twisted.allFinite()) return;
  moved_ += off;
  turned_ += twisted;
  memory_.pose = moved(memory_.pose, off, twisted);
}

BodyForce LocalBody::touch(const Pose& device, double age, double elapsed,
                           WorkLimit* work) noexcept {
  BodyForce force;
  last_weight_ = 0.0;
  const bool whole = has_whole();
  if (!memory_.placed || !(model_.reach > 0.0) || (model_.solids != 0 && !whole)) return force;
  memory_.known = false;  // The surfaces may have moved since the last contact.
  const ModelledSurroundings surroundings(model_, age, elapsed,
                                          whole ? whole_->solids.get() : nullptr);
  const CoupledTool tool{
      model_.coupling, model_.radius,
      std::ranges::any_of(model_.surfaces(),
                          [](const BodyPatch& patch) { return !patch.velocity.isZero(0.0); }),
      whole ? &whole_->inertia : nullptr, work};
  force.command = step_coupled_tool(tool, surroundings, device, elapsed, memory_).command;
  if (is_cut(work)) {
    clear();
    return {.command = {}, .weight = 0.0, .cut = true};
  }
  if (!force.command.finite()) {
    clear();
    return {};
  }
  force.weight = last_weight_ = weight_at(model_, memory_.pose);
  past_[ticks_++ % kRemembered] = {memory_.pose, moved_, turned_};
  return force;
}

}  // namespace feltwire
