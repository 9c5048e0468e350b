#include "core/arm/arm_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/file_error.hpp"

namespace feltwire::arm {
namespace {

/// Finds the parts of an arm in the model by their names. Each name begins with the prefix.
class Parts {
 public:
  Parts(const mjModel& model, std::string file, std::string prefix)
      : model_(model), file_(std::move(file)), prefix_(std::move(prefix)) {}

  [[noreturn]] void fail(const std::string& what) const { throw FileError(file_ + ": " + what); }

  int site(const char* own, const char* meaning) const {
    const std::string name = prefix_ + own;
    const int id = mj_name2id(&model_, mjOBJ_SITE, name.c_str());
    if (id < 0) fail(missing("site", name) + "; add <site name=\"" + name + "\"/> " + meaning);
    return id;
  }

  /// Returns the index in `sensordata` of the first of the sensor's three numbers.
  int sensor(const char* own, mjtSensor type, const char* tag, int site) const {
    const std::string name = prefix_ + own;
    const int id = mj_name2id(&model_, mjOBJ_SENSOR, name.c_str());
    const std::string at = mj_id2name(&model_, mjOBJ_SITE, site);
    const std::string remedy =
        "<" + std::string(tag) + " name=\"" + name + "\" site=\"" + at + "\"/>";
    if (id < 0) fail(missing("sensor", name) + "; add " + remedy);
    if (model_.sensor_type[id] != type || model_.sensor_objid[id] != site)
      fail("sensor '" + name + "' is of another kind or at another site; write " + remedy);
    if (model_.sensor_cutoff[id] > 0.0) fail("sensor '" + name + "' has a cutoff; remove it");
    return model_.sensor_adr[id];
  }

  Axis axis(const std::string& own, mjtJoint type, const char* kind) const {
    const std::string name = prefix_ + own;
    Axis a;
    a.joint = mj_name2id(&model_, mjOBJ_JOINT, name.c_str());
    if (a.joint < 0)
      fail(missing("joint", name) + "; an arm has the " + kind + " joints " + prefix_ +
           "joint1 to " + prefix_ + "joint7");
    if (model_.jnt_type[a.joint] != type)
      fail("joint '" + name + "' is no " + kind + " joint; give it type=\"" + kind + "\"");
    if (model_.jnt_limited[a.joint] == 0)
      fail("joint '" + name + "' has no limits; give it limited=\"true\" and a range");
    a.position = model_.jnt_qposadr[a.joint];
    a.speed = model_.jnt_dofadr[a.joint];
    a.low = mujoco::entry<2>(model_.jnt_range, a.joint)[0];
    a.high = mujoco::entry<2>(model_.jnt_range, a.joint)[1];
    a.motor = motor(name, a.joint);
    a.most = mujoco::entry<2>(model_.actuator_ctrlrange, a.motor)[1];
    return a;
  }

  Vec7 home(const std::array<Axis, kAxes>& axes) const {
    const int id = mj_name2id(&model_, mjOBJ_NUMERIC, (prefix_ + "home").c_str());
    if (id < 0 || model_.numeric_size[id] != kAxes)
      fail("has no <numeric name=\"" + prefix_ +
           "home\"> of seven angles [rad]; add it to <custom>");
    Vec7 home;
    for (int i = 0; i < kAxes; ++i) {
      const Axis& a = axes.at(static_cast<std::size_t>(i));
      home[i] = model_.numeric_data[model_.numeric_adr[id] + i];
      if (!(home[i] >= a.low && home[i] <= a.high))
        fail("home: angle " + std::to_string(i + 1) + " is " + std::to_string(home[i]) +
             " rad, outside of the joint's range; give one from " + std::to_string(a.low) + " to " +
             std::to_string(a.high));
    }
    return home;
  }

  bool has_joint(const char* own) const {
    return mj_name2id(&model_, mjOBJ_JOINT, (prefix_ + own).c_str()) >= 0;
  }

 private:
  static std::string missing(const char* kind, const std::string& name) {
    return "has no " + std::string(kind) + " '" + name + "'";
  }

  /// Returns the index of the joint's only motor. The control value of this motor is a torque [N m]
  /// or a force [N].
  int motor(const std::string& name, int joint) const {
    for (int m = 0; m < model_.nu; ++m) {
      if (model_.actuator_trnid[std::ptrdiff_t{2} * m] != joint) continue;
      const mjtNum* range = mujoco::entry<2>(model_.actuator_ctrlrange, m);
      const bool plain = model_.actuator_trntype[m] == mjTRN_JOINT &&
                         model_.actuator_dyntype[m] == mjDYN_NONE &&
                         model_.actuator_gaintype[m] == mjGAIN_FIXED &&
                         model_.actuator_biastype[m] == mjBIAS_NONE &&
                         mujoco::entry<mjNGAIN>(model_.actuator_gainprm, m)[0] == 1.0 &&
                         mujoco::entry<6>(model_.actuator_gear, m)[0] == 1.0;
      if (!plain || model_.actuator_ctrllimited[m] == 0 || !(range[1] > 0.0) ||
          range[0] != -range[1])
        fail("the motor of joint '" + name + "' is no plain one; " + remedy(name));
      return m;
    }
    fail("joint '" + name + "' has no motor; " + remedy(name));
  }
  static std::string remedy(const std::string& joint) {
    return "write <motor joint=\"" + joint +
           "\" ctrllimited=\"true\" ctrlrange=\"-MOST MOST\"/>, without a gear";
  }

  const mjModel& model_;
  std::string file_, prefix_;
};

}  // namespace

ArmParts find_arm(const mjModel& model, const std::string& file, const std::string& prefix) {
  const Parts parts(model, file, prefix);
  ArmParts arm;
  for (int i = 0; i < kAxes; ++i)
    arm.axes.at(static_cast<std::size_t>(i)) =
        parts.axis("joint" + std::to_string(i + 1), mjJNT_HINGE, "hinge");
  if (parts.has_joint("finger1"))
    arm.fingers = {parts.axis("finger1", mjJNT_SLIDE, "slide"),
                   parts.axis("finger2", mjJNT_SLIDE, "slide")};
  arm.home = parts.home(arm.axes);
  arm.tool = parts.site("tool", "where targets act");
  arm.wrist = parts.site("wrist", "where the wrist's sensor is");
  arm.balance = parts.site("balance", "at the centre of mass of the tool");
  arm.hand = model.site_bodyid[arm.wrist];
  if (model.site_bodyid[arm.balance] != arm.hand || model.site_bodyid[arm.tool] != arm.hand)
    parts.fail("the sites 'tool', 'wrist' and 'balance' are not of one body; put all in the hand");
  for (const int site : {arm.wrist, arm.balance})
    if (std::abs(mujoco::entry<4>(model.site_quat, site)[0]) < 1.0 - 1e-9)
      parts.fail("the sites 'wrist' and 'balance' are turned; remove their quat");
  arm.force = parts.sensor("wrist_force", mjSENS_FORCE, "force", arm.wrist);
  arm.torque = parts.sensor("wrist_torque", mjSENS_TORQUE, "torque", arm.wrist);
  arm.acceleration =
      parts.sensor("tool_acceleration", mjSENS_ACCELEROMETER, "accelerometer", arm.balance);
  arm.tool_mass = model.body_subtreemass[arm.hand];
  return arm;
}

void go_home(const ArmParts& arm, const std::optional<double>& gripper,
             mjtNum* coordinates) noexcept {
  for (int i = 0; i < kAxes; ++i)
    coordinates[arm.axes.at(static_cast<std::size_t>(i)).position] = arm.home[i];
  if (!arm.fingers) return;
  for (const Axis& finger : *arm.fingers)
    coordinates[finger.position] =
        gripper ? std::clamp(0.5 * *gripper, finger.low, finger.high) : finger.high;
}

}  // namespace feltwire::arm
