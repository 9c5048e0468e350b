#include "core/tool_coupling/descent.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire::tool_coupling {
namespace {

/// A spring whose force is at most `most`.
struct Spring {
  double stiffness, most;

  /// Returns the energy [J] at a stretch. It is quadratic until the spring saturates, and linear
  /// beyond.
  double energy(double stretch) const {
    const double linear_from = most / stiffness;
    return stretch <= linear_from ? 0.5 * stiffness * stretch * stretch
                                  : most * (stretch - 0.5 * linear_from);
  }
  /// Returns force / stretch. This is also the stiffness of the parabola that touches the energy
  /// curve at this stretch and lies above the curve everywhere else.
  double secant(double stretch) const {
    return stiffness * stretch <= most ? stiffness : most / stretch;
  }
};

/// Returns the stiffness minus a share of the softening. The share is 1, 1/2, 1/4 or 0, so that at
/// least a tenth of the stiffness remains in every direction.
Mat6 softened(const Mat6& stiffness, const Mat6& softening) {
  constexpr double kLeft = 0.1;
  if (softening.isZero(0.0)) return stiffness;
  for (const double share : {1.0, 0.5, 0.25}) {
    Mat6 whole = stiffness - share * softening;
    if (Mat6(whole - kLeft * stiffness).llt().info() == Eigen::Success) return whole;
  }
  return stiffness;
}

}  // namespace

Pull pull(const ToolCoupling& c, const Pose& device, const Pose& tool) {
  const Spring linear{c.stiffness, c.max_force};
  const Spring rotational{c.rotational_stiffness, c.max_torque};
  const Vec3 stretch = device.position - tool.position;
  const Vec3 twist = rotation_between(tool.orientation, device.orientation);
  const double stretched = length(stretch), twisted = length(twist);
  Pull result;
  result.energy = linear.energy(stretched) + rotational.energy(twisted);
  result.stiffness = linear.secant(stretched);
  result.rotational_stiffness = rotational.secant(twisted);
  result.wrench << result.stiffness * stretch, result.rotational_stiffness * twist;
  return result;
}

State Step::at(const Pose& pose) const {
  constexpr std::uint64_t kStateWork = 16;
  may_go_on(tool.work, kStateWork);
  State state{pose, pull(tool.coupling, device, pose), surroundings.contact(pose, tool.work)};
  if (inertial != nullptr) state.inertial = inertial->energy(pose);
  ++result.evaluations;
  result.looked_at += state.contact.looked_at;
  return state;
}

FrictionSolution Step::model(const State& state, bool slipping) const {
  Mat6 stiffness = state.contact.stiffness + damping;
  stiffness.diagonal().head<3>().array() += state.pull.stiffness;
  stiffness.diagonal().tail<3>().array() += state.pull.rotational_stiffness;
  Vec6 wrench = state.pull.wrench + state.contact.wrench + damped(done);
  if (inertial != nullptr) {
    const InertialStep::Term term = inertial->term(state.pose);
    stiffness += term.stiffness;
    stiffness.diagonal() += dashpot.drag;
    wrench += term.wrench + dashpot.wrench(done);
  }
  return solve_friction(softened(stiffness, state.contact.softening), wrench, gripping(state),
                        slipping, tool.work);
}

Vec6 Step::allowed(const State& state, const Vec6& way) const {
  const double farthest = length_of(way), most = state.contact.clearance + kToolAdvance;
  return farthest > most ? Vec6(way * (most / farthest)) : way;
}

void Step::damp(const State& state, bool slipping) {
  const ShellContact& contact = state.contact;
  if (!(elapsed > 0.0) || contact.part_count == 0) return;
  damping = contact.viscosity.resistance / elapsed;
  driven = contact.viscosity.driven / elapsed;
  if (contact.damping.resistance.isZero(0.0)) return;
  const Vec6 free = model(state, slipping).motion;
  const Mat6 full = contact.damping.resistance / elapsed;
  const double held = free.dot(full * free);
  const double pushed = free.dot(contact.wrench - contact.stiffness * free);
  double share = 1.0;
  if (contact.wrench.dot(free) > 0.0 && held > pushed) share = std::max(0.0, pushed / held);
  damping += share * full;
  driven += share / elapsed * contact.damping.driven;
}

FrictionSolution descend(Step& step, State& state, bool& slipping) {
  // Least movements, as shares of the tool's radius. The search ends if the first movement is below
  // kClose, or if a later movement is below kCloseEnough.
  constexpr double kClose = 1e-5, kCloseEnough = 1e-4;
  // For a tool with mass, the limit is much smaller, because the velocity is the movement divided
  // by the time. A tool that friction holds counts as at rest.
  constexpr double kCloseWithMass = 1e-12, kRounding = 1e-7;
  const bool has_mass = step.inertial != nullptr;
  const double radius = step.tool.radius;
  const std::size_t before = step.result.evaluations;
  const auto next_slide = [&] {
    FrictionSolution next = step.model(state, slipping);
    if (next.slips && !slipping) {
      slipping = true;
      next = step.model(state, slipping);
    }
    return next;
  };
  FrictionSolution next = next_slide();
  bool slips = next.slips;  // true if the tool slips in any iteration of this step
  Vec6 way = step.allowed(state, next.motion);
  // If objects move, follow even a slow movement.
  const double least = step.tool.surroundings_move ? 0.0 : kClose * radius;
  const auto enough = [&] {
    if (!has_mass) return kCloseEnough * radius;
    return std::max(step.gripping(state).empty() ? 0.0 : 2.0 * kHeld, kCloseWithMass * radius);
  };
  const auto done = [&] { return step.tool.work != nullptr ? step.tool.work->done() : 0; };
  std::uint64_t look = done();  // estimated units of work of a query
  while (step.result.evaluations < step.budget && !is_cut(step.tool.work)) {
    const bool first = step.result.evaluations == before;
    if (!(step.length_of(way) > (first && !has_mass ? least : enough()))) break;
    if (!step.has_room_for(look)) {
      if (first) step.tool.work->take(WorkLimit::kUnlimited);
      break;
    }
    const std::uint64_t began = done();
    State tried = step.at(moved(state.pose, way.head<3>(), way.tail<3>()));
    const std::span<const FrictionPatch> patches = step.gripping(state);
    const double cost = friction_work(patches, slipping, way) -
                        friction_work(patches, slipping, Vec6::Zero()) +
                        step.damping_work(step.done + way) - step.damping_work(step.done);
    const double damped =
        has_mass ? step.dashpot.work(step.done + way) - step.dashpot.work(step.done) : 0.0;
    if (tried.energy() + cost + damped < state.energy()) {
      state = tried;
      step.done += way;
      step.paid += cost;
      // The tool has already moved with the object that carries it. Any further movement is slip.
      for (std::size_t i = 0; i < state.contact.grip_count; ++i)
        state.contact.patches[i].carried.setZero();
      next = next_slide();
      slips |= next.slips;
      way = step.allowed(state, next.motion);
    } else if (has_mass && step.length_of(way) < kRounding * radius) {
      break;  // The energy would fall by less than its rounding error.
    } else {
      way *= 0.5;
    }
    look = std::max(first ? 0 : look, done() - began);
  }
  slipping = slips && !step.gripping(state).empty();
  return next;
}

bool good(const Pose& pose) {
  const double squared = pose.orientation.squaredNorm();
  return pose.position.allFinite() && std::isfinite(squared) && squared > 0.0;
}

bool usable(const State& state) {
  return std::isfinite(state.energy()) && state.pull.wrench.allFinite() && good(state.pose);
}

Vec6 resistance(const Step& step, const State& state, const FrictionSolution& last) {
  Vec6 resisted = step.damped(step.done);
  for (std::size_t i = 0; i < state.contact.grip_count; ++i) resisted += last.friction[i];
  return resisted;
}

void share_out(const State& state, const FrictionSolution& last, const Vec6& whole,
               BodyStep& result) {
  const ShellContact& contact = state.contact;
  const auto parts = std::span(result.parts).first(contact.part_count);
  std::copy_n(contact.parts.begin(), parts.size(), parts.begin());
  Vec6 rest = whole;
  double sizes = 0.0;
  for (ObjectWrench& part : parts) {
    for (std::size_t i = 0; i < contact.grip_count; ++i)
      if (contact.patches[i].object == part.object) part.wrench += last.friction[i];
    rest -= part.wrench;
    sizes += part.wrench.head<3>().norm();
  }
  if (!(sizes > 0.0)) return;
  result.part_count = parts.size();
  for (ObjectWrench& part : parts) part.wrench += part.wrench.head<3>().norm() / sizes * rest;
}

}  // namespace feltwire::tool_coupling
