#include "sim/studies/scene/mujoco_tool.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/text.hpp"

namespace feltwire {
namespace {

std::string numbers(const Vec3& v) {
  std::string text;
  append(text, "%.17g %.17g %.17g ", v.x(), v.y(), v.z());
  return text;
}

std::string numbers(const Quaternion& q) {
  std::string text;
  append(text, "%.17g %.17g %.17g %.17g", q.w(), q.x(), q.y(), q.z());
  return text;
}

/// Returns the MJCF geoms of the parts, and adds the meshes of the parts to `assets`.
std::string geoms(const char* name, const std::vector<std::vector<Vec3>>& parts,
                  std::string& assets) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    append(assets, "<mesh name=\"%s%zu\" vertex=\"", name, i);
    for (const Vec3& corner : parts[i]) assets += numbers(corner);
    assets += "\"/>";
    append(text, "<geom type=\"mesh\" mesh=\"%s%zu\"/>", name, i);
  }
  return text;
}

std::string box_geom(const Vec3& at, const Vec3& half) {
  return "<geom type=\"box\" pos=\"" + numbers(at) + "\" size=\"" + numbers(half) + "\"/>";
}

/// Returns the MJCF geoms of the walls around a pocket with this half size [m].
std::string walls(const Vec3& half) {
  constexpr double kThick = 0.02;  // [m] half the thickness of a wall
  std::string text;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      Vec3 at = Vec3::Zero(), size = half + Vec3::Constant(2.0 * kThick);
      at[axis] = side * (half[axis] + kThick);
      size[axis] = kThick;
      text += box_geom(at, size);
    }
  return text;
}

std::string model_text(const SixDofTask& task, const ToolInertia& body) {
  std::string assets, text;
  std::string solid = geoms("solid", task.solid.parts, assets);
  if (task.box)
    solid = task.side == Side::inside ? walls(task.box->half_extents)
                                      : box_geom(Vec3::Zero(), task.box->half_extents);
  const std::string parts = geoms("tool", task.tool.parts, assets);
  // MuJoCo's stiffness and damping are per unit of mass.
  const double stiffness = kSixDofStiffness / body.mass;
  append(text,
         "<mujoco><compiler coordinate=\"local\"/><size njmax=\"8000\" nconmax=\"2000\"/>"
         "<option timestep=\"%.17g\" gravity=\"0 0 0\"/>"
         "<default><geom condim=\"1\" solref=\"%.17g %.17g\"/></default><asset>",
         kSixDofPeriod, -stiffness, -2.0 * std::sqrt(stiffness));
  text += assets + "</asset><worldbody><body pos=\"" + numbers(task.place.position) + "\" quat=\"" +
          numbers(task.place.orientation) + "\">" + solid +
          "</body><body name=\"tool\"><freejoint/><inertial pos=\"" + numbers(body.center);
  const Mat3& i = body.inertia;
  append(text, "\" mass=\"%.17g\" fullinertia=\"%.17g %.17g %.17g %.17g %.17g %.17g\"/>", body.mass,
         i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2));
  return text + parts + "</body></worldbody></mujoco>";
}

mujoco::Model compiled(const std::string& text) {
  mujoco::Loaded loaded = mujoco::load_text(text);
  if (!loaded.model) throw std::runtime_error("MuJoCo: " + loaded.error);
  return std::move(loaded.model);
}

/// Calls `call`, which calls MuJoCo. Throws std::runtime_error if MuJoCo fails.
template <class Call>
void require(Call call) {
  if (!mujoco::guarded(call)) throw std::runtime_error("MuJoCo cannot compute a task");
}

constexpr int kTool = 2;  // index of the tool's body, after the world and the solid

}  // namespace

MujocoTool::MujocoTool(const SixDofTask& task, const SixDofTool& tool)
    : tool_(tool.tool),
      model_(compiled(model_text(task, tool_.inertia()))),
      data_(mujoco::make_data(*model_)) {
  if (!data_) throw std::runtime_error("MuJoCo has no room for a task");
  place(task.device(0.0));
}

void MujocoTool::place(const Pose& device) {
  before_ = device;
  device_velocity_.setZero();
  mjModel* const model = model_.get();
  mjData* const data = data_.get();
  require([&] { mj_resetData(model, data); });
  const Quaternion& q = device.orientation;
  Eigen::Map<Eigen::Matrix<double, 7, 1>>(data_->qpos) << device.position, q.w(), q.x(), q.y(),
      q.z();
  require([&] { mj_forward(model, data); });
}

Pose MujocoTool::pose() const {
  return {mujoco::vector(data_->qpos), mujoco::quaternion(data_->qpos + 3)};
}

Vec6 MujocoTool::pull(const Pose& device) const {
  const Pose at = pose();
  const ToolCoupling& spring = tool_.coupling();
  const ToolInertia& damper = tool_.inertia();
  const double* v = data_->qvel;  // linear velocity in the world frame, angular in the tool's
  Vec6 wrench;
  wrench << spring.stiffness * (device.position - at.position) +
                damper.damping * (device_velocity_.head<3>() - mujoco::vector(v)),
      spring.rotational_stiffness * rotation_between(at.orientation, device.orientation) +
          damper.rotational_damping *
              (device_velocity_.tail<3>() - at.orientation * mujoco::vector(v + 3));
  return wrench;
}

Vec6 MujocoTool::step(const Pose& device) {
  device_velocity_ << (device.position - before_.position) / kSixDofPeriod,
      rotation_between(before_.orientation, device.orientation) / kSixDofPeriod;
  before_ = device;
  Vec6 wrench = pull(device);
  const Vec3 arm = pose().orientation * tool_.inertia().center, force = wrench.head<3>();
  wrench.tail<3>() -= arm.cross(force);  // the torque is now about the centre of mass
  Eigen::Map<Vec6>(data_->xfrc_applied + std::ptrdiff_t{6} * kTool) = wrench;
  mjModel* const model = model_.get();
  mjData* const data = data_.get();
  require([&] { mj_step(model, data); });
  return -pull(device);
}

std::size_t MujocoTool::bytes() const {
  return static_cast<std::size_t>(mj_sizeModel(model_.get()));
}

}  // namespace feltwire
