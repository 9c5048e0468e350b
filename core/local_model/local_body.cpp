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

void LocalBody::take(const BodyModel& model) noexcept {
  if (!(last_weight_ > 0.0) || !memory_.placed || model.scene != model_.scene) {
    memory_ = {};
    memory_.placed = model.reach > 0.0;
    memory_.pose = model.tool;
    memory_.slipping = model.slipping;
  }
  model_ = model;
}

BodyForce LocalBody::touch(const Pose& device, double age, double elapsed) noexcept {
  BodyForce force;
  last_weight_ = 0.0;
  if (!memory_.placed || !(model_.reach > 0.0)) return force;
  memory_.known = false;  // surfaces may have moved
  const ModelledSurroundings surroundings(model_, age, elapsed);
  const CoupledTool tool{model_.coupling, model_.radius,
                         std::ranges::any_of(model_.surfaces(), [](const BodyPatch& patch) {
                           return !patch.velocity.isZero(0.0);
                         })};
  force.command = step_coupled_tool(tool, surroundings, device, elapsed, memory_).command;
  if (!force.command.finite()) {
    clear();
    return {};
  }
  force.weight = last_weight_ = weight_at(model_, memory_.pose);
  return force;
}

}  // namespace feltwire
