#include "server/scene/reply_deadband.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/local_model/local_contact.hpp"

namespace feltwire {
namespace {

// An old model is used within this share of its reach, and a patch within this share of its radius.
constexpr double kKnown = 0.5;

}  // namespace

bool describes(const LocalModel& sent, const LocalModel& now, double since, double force) noexcept {
  // This comparison is false for NaN and for an empty model (reach 0), so the result is false.
  if (!(length(now.center - sent.center) < kKnown * sent.reach)) return false;
  for (const SurfacePatch& patch : now.view()) {
    const auto known = std::ranges::find_if(sent.view(), [&](const SurfacePatch& s) {
      return s.object == patch.object && s.feature == patch.feature;
    });
    if (known == sent.view().end()) {
      // The patch is new if it is within the reach of `sent`. Beyond it, `sent` has no patches.
      if (length(patch.point - sent.center) < sent.reach) return false;
      continue;
    }
    if (patch.whole && known->whole && now.surfaces == sent.surfaces) continue;
    const Vec3 moved = since * known->velocity;
    const double along = length(patch.point - known->point - moved);
    if (known->joined != patch.joined || known->offset != patch.offset ||
        !(along <= kKnown * known->radius) ||
        !(std::abs(height_above(*known, moved, patch.point).height) <=
          force / known->material.stiffness))
      return false;
  }
  return true;
}

bool ReplyDeadband::withhold(Reply& reply) noexcept {
  if (!on()) return false;
  reply.predicted = parameters_.predictor == Predictor::linear;
  if (reply.predicted) reply.rates = trend_.rates();
  if (any_ && !differs(reply)) return true;
  any_ = true;
  command_ = reply.command;
  rates_ = reply.rates;
  model_.reach = 0.0;
  if (reply.modelled) model_ = reply.model;
  refused_ = reply.bound.refused;
  saturated_ = reply.bound.saturated;
  recovering_ = reply.recovering;
  since_ = 0.0;
  return false;
}

bool ReplyDeadband::differs(const Reply& reply) const noexcept {
  const SessionParameters& p = parameters_;
  // The next reply is possible only after packet_interval ticks. Reply now if that is later than
  // keep_alive. Half a tick is a tolerance for the jitter of the servo.
  const double next = (p.packet_interval - 0.5) * p.servo_period;
  if (!(since_ + next < p.keep_alive)) return true;
  if (reply.gap || reply.bound.refused != refused_ || reply.bound.saturated != saturated_)
    return true;
  if (reply.recovering || recovering_) return true;
  if (acts(reply.command) != acts(command_)) return true;
  // Friction changes a contact of the tool's body over time, and describes() cannot compare body
  // models. So send every body model that has a contact.
  if (reply.body_modelled && (reply.body.count > 0 || reply.body.solids != 0)) return true;
  if (reply.modelled && reply.model.reach > 0.0) {
    const double unfelt = p.force_deadband * length(reply.command.force()) + kUnfeltForce;
    if (!describes(model_, reply.model, since_, unfelt)) return true;
    // The patches do not contain the texture of a surface. If a patch is rough, compare the forces.
    const auto rough = [](const SurfacePatch& patch) { return patch.rough; };
    if (std::ranges::none_of(reply.model.view(), rough)) return false;
  }
  const Command known = extrapolated(command_, rates_, std::min(since_, p.keep_alive));
  return beyond_deadband(reply.command, known, p.force_deadband);
}

}  // namespace feltwire
