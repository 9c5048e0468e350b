#include "core/tool/body_tool.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/numeric.hpp"

namespace feltwire {
namespace {

void require(bool good, const char* field, double value, const char* unit) {
  if (!good)
    throw std::invalid_argument(std::string(field) + ": must be above zero " + unit + ", is " +
                                std::to_string(value) + "; leave it out or give a larger number");
}

/// A spring that pulls with no more than `most`.
struct Spring {
  double stiffness, most;

  /// [J] Quadratic up to where it saturates, linear beyond.
  double energy(double stretch) const {
    const double linear_from = most / stiffness;
    return stretch <= linear_from ? 0.5 * stiffness * stretch * stretch
                                  : most * (stretch - 0.5 * linear_from);
  }
  /// Force over stretch: also the stiffness of the parabola that touches the energy there and lies
  /// above it everywhere.
  double secant(double stretch) const {
    return stiffness * stretch <= most ? stiffness : most / stretch;
  }
};

/// How the device pulls on the tool.
struct Pull {
  double energy = 0.0;         // [J]
  Vec6 wrench = Vec6::Zero();  // on the tool
  double stiffness = 0.0, rotational_stiffness = 0.0;
};

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

/// Everything at one pose of the tool.
struct State {
  Pose pose;
  Pull pull;
  ShellContact contact;
  double energy() const { return pull.energy + contact.energy; }
};

State state_at(const BodyTool& tool, std::span<const Object> objects, const Pose& device,
               const Pose& pose, BodyStep& step) {
  State state{pose, pull(tool.coupling(), device, pose), {}};
  for (const Object& object : objects)
    add_contact(tool.shell(), pose, object, tool.contact_area(), state.contact);
  ++step.evaluations;
  step.looked_at += state.contact.looked_at;
  return state;
}

/// Where the Gauss-Newton model of the energy has its minimum, no farther than the clearance
/// allows.
Vec6 newton_step(const State& state, double radius) {
  Mat6 stiffness = state.contact.stiffness;
  stiffness.diagonal().head<3>().array() += state.pull.stiffness;
  stiffness.diagonal().tail<3>().array() += state.pull.rotational_stiffness;
  Vec6 step = stiffness.ldlt().solve(state.pull.wrench + state.contact.wrench);
  const double farthest = step.head<3>().norm() + radius * step.tail<3>().norm();
  const double allowed = state.contact.clearance + kToolAdvance;
  if (farthest > allowed) step *= allowed / farthest;
  return step;
}

bool good(const Pose& pose) {
  const double squared = pose.orientation.squaredNorm();
  return pose.position.allFinite() && std::isfinite(squared) && squared > 0.0;
}

}  // namespace

Pose moved(const Pose& pose, const Vec3& by, const Vec3& turn) noexcept {
  const Polar<double> angle = polar(turn);
  if (!(angle.length > 0.0)) return {pose.position + by, pose.orientation};
  const Quaternion rotation(Eigen::AngleAxisd(angle.length, angle.direction));
  return {pose.position + by, (rotation * pose.orientation).normalized()};
}

BodyTool::BodyTool(PointShell shell, const ToolCoupling& coupling, double contact_area)
    : shell_(std::move(shell)), coupling_(coupling), contact_area_(contact_area) {
  if (shell_.points.empty() || !(shell_.radius > 0.0))
    throw std::invalid_argument("body: has no extent about the tool's origin; give a larger one");
  ToolCoupling& c = coupling_;
  if (c.rotational_stiffness == 0.0)
    c.rotational_stiffness = c.stiffness * shell_.radius * shell_.radius;
  if (c.max_torque == 0.0) c.max_torque = c.max_force * shell_.radius;
  if (contact_area_ == 0.0) contact_area_ = shell_.area / 6.0;  // a cube's face
  const auto above_zero = [](double x) { return x > 0.0 && std::isfinite(x); };
  require(above_zero(c.stiffness), "stiffness", c.stiffness, "[N/m]");
  require(above_zero(c.rotational_stiffness), "rotational_stiffness", c.rotational_stiffness,
          "[N m/rad]");
  require(above_zero(c.max_force), "max_force", c.max_force, "[N]");
  require(above_zero(c.max_torque), "max_torque", c.max_torque, "[N m]");
  require(above_zero(contact_area_), "contact_area", contact_area_, "[m^2]");
}

BodyStep step_body(const BodyTool& tool, std::span<const Object> objects, const Pose& device,
                   BodyMemory& memory) noexcept {
  BodyStep step;
  if (!good(device)) return step;
  if (!memory.placed) {
    memory.pose = device;
    memory.pose.orientation.normalize();
    memory.placed = true;
  }
  // Of the radius: what is not worth a look, and not worth another one in the same step.
  constexpr double kClose = 1e-5, kCloseEnough = 1e-4;
  const double radius = tool.shell().radius;
  State state = memory.known
                    ? State{memory.pose, pull(tool.coupling(), device, memory.pose), memory.contact}
                    : state_at(tool, objects, device, memory.pose, step);
  Vec6 way = newton_step(state, radius);
  while (step.evaluations < kToolEvaluations) {
    const double least = (step.evaluations == 0 ? kClose : kCloseEnough) * radius;
    if (!(way.head<3>().norm() + radius * way.tail<3>().norm() > least)) break;
    const State next =
        state_at(tool, objects, device, moved(state.pose, way.head<3>(), way.tail<3>()), step);
    if (next.energy() < state.energy()) {
      state = next;
      way = newton_step(state, radius);
    } else {
      way *= 0.5;
    }
  }
  if (!std::isfinite(state.energy()) || !state.pull.wrench.allFinite() || !good(state.pose))
      [[unlikely]]
    return step;  // poses beyond what products can hold
  memory.pose = state.pose;
  memory.contact = state.contact;
  memory.known = true;
  step.command.elastic = -state.pull.wrench.head<3>();
  step.command.torque = -state.pull.wrench.tail<3>();
  step.stored = state.energy();
  step.touching = state.contact.touching;
  return step;
}

}  // namespace feltwire
