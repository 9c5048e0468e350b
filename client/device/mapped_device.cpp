#include "client/device/mapped_device.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

namespace feltwire {
namespace {

constexpr double kSmallestScale = 0.01, kLargestScale = 100.0;
constexpr double kFarthest = 100.0;  // [m] largest translation along an axis
constexpr double kRounded = 1e-14;   // rounding error of a matrix element that should be an integer

void require_of_mapping(bool good, const char* message) {
  if (!good) throw std::invalid_argument(message);
}

/// Returns the damping in the scene, M B M' / s^2, with the axes M, the device's damping B and the
/// scale s. It is isotropic or diagonal if possible.
Damping mapped(const Damping& damping, const Mat3& axes, double scale) {
  const double square = scale * scale;
  if (damping.isotropic()) return {damping.matrix()(0, 0) / square};
  const Mat3 turned = axes * damping.matrix() * axes.transpose() / square;
  const Mat3 symmetric = 0.5 * (turned + turned.transpose());
  if (symmetric.isDiagonal(kRounded)) return {Vec3(symmetric.diagonal())};
  return {symmetric};
}

/// Returns the largest factor by which a box along the device's axes becomes wider along an axis of
/// the scene.
double widening(const Mat3& axes) { return axes.cwiseAbs().rowwise().sum().maxCoeff(); }

}  // namespace

Mat3 WorkspaceMapping::axes() const {
  const double angle = rotation.norm();
  Mat3 m = Mat3::Identity();
  if (angle > 0.0) m = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  if (mirrored_axis) m.col(*mirrored_axis) *= -1.0;
  return m.unaryExpr(
      [](double v) { return std::abs(v - std::round(v)) < kRounded ? std::round(v) : v; });
}

void validate(const WorkspaceMapping& mapping) {
  require_of_mapping(
      mapping.scale >= kSmallestScale && mapping.scale <= kLargestScale,
      "map_scale of --device must be from 0.01 to 100; 2 moves the tool twice as far as the "
      "hand");
  require_of_mapping(
      mapping.rotation.norm() <= 2.0 * std::numbers::pi,
      "map_rotate of --device: the vector's length is the angle, at most 360 degrees");
  require_of_mapping(mapping.translation.cwiseAbs().maxCoeff() <= kFarthest,
                     "map_translate of --device must be within 100 m along each axis");
  require_of_mapping(
      !mapping.mirrored_axis || (*mapping.mirrored_axis >= 0 && *mapping.mirrored_axis < 3),
      "map_mirror of --device must be x, y or z");
}

DeviceSpec mapped_spec(const DeviceSpec& device, const WorkspaceMapping& mapping) {
  validate(mapping);
  const double s = mapping.scale, square = s * s;
  const Mat3 axes = mapping.axes();
  DeviceSpec spec = device;
  if (device.translation_dof == 2 && std::abs(axes(2, 2)) != 1.0) spec.translation_dof = 3;
  spec.damping = mapped(device.damping, axes, s);
  spec.rotational_damping = mapped(device.rotational_damping, axes, 1.0);
  for (double* mass : {&spec.apparent_mass, &spec.least_mass}) *mass /= square;
  for (double* force : {&spec.coulomb_friction, &spec.least_friction, &spec.max_force,
                        &spec.continuous_force, &spec.hand_force})
    *force /= s;
  spec.position_resolution *= s * widening(axes);
  spec.rotation.resolution *= widening(axes);
  spec.hand_speed *= s;
  spec.workspace = s * (axes.cwiseAbs() * device.workspace);
  try {
    validate(spec);
  } catch (const DeviceSpecError& error) {
    std::ostringstream message;
    message << "map_scale of --device " << s << " does not suit device '" << device.name
            << "': " << error.field << ": " << error.why << ". Give a scale nearer to 1";
    throw std::invalid_argument(message.str());
  }
  return spec;
}

MappedDevice::MappedDevice(std::unique_ptr<Device> device, const WorkspaceMapping& mapping)
    : device_(std::move(device)),
      scale_(mapping.scale),
      axes_(mapping.axes()),
      turning_(axes_.determinant() < 0.0 ? -1.0 : 1.0),
      spec_(mapped_spec(device_->spec(), mapping)),
      tool_{.position = mapping.translation},
      command_delay_(device_->spec().actuation.late_ticks) {}

void MappedDevice::begin(const Vec3& position, const Vec3& normal) {
  device_->begin(hand_.position + axes_.transpose() * (position - tool_.position) / scale_,
                 axes_.transpose() * normal);
}

/// Returns the pose in the scene of a pose of the device. Maps `hand_` exactly to `tool_`. Maps the
/// rotation quaternion (w, v) to (w, det(M) M v), with the axes M.
Pose MappedDevice::in_scene(const Pose& pose) const noexcept {
  Pose mapped = tool_;
  mapped.position += scale_ * (axes_ * (pose.position - hand_.position));
  if (pose.orientation.coeffs() == hand_.orientation.coeffs()) return mapped;
  const Quaternion turned = pose.orientation * hand_.orientation.conjugate();
  const Vec3 v = turning_ * (axes_ * turned.vec());
  mapped.orientation = Quaternion(turned.w(), v.x(), v.y(), v.z()) * tool_.orientation;
  return mapped;
}

Command MappedDevice::to_scene(const Command& c) const noexcept {
  return {.elastic = axes_ * c.elastic / scale_,
          .frictional = axes_ * c.frictional / scale_,
          .torque = turning_ * (axes_ * c.torque)};
}

Command MappedDevice::to_device(const Command& c) const noexcept {
  return {.elastic = scale_ * (axes_.transpose() * c.elastic),
          .frictional = scale_ * (axes_.transpose() * c.frictional),
          .torque = turning_ * (axes_.transpose() * c.torque)};
}

/// Updates the state of the clutch, and maps the pose of `reading`. `holds`: the device held a
/// force since the last reading, or a written force has not yet arrived.
void MappedDevice::clutch(DeviceReading& reading, bool holds) noexcept {
  const Pose hand = reading.pose;
  switch (state_) {
    case Tool::led:
      if (reading.clutch) state_ = Tool::let_go;
      break;
    case Tool::let_go:
      if (holds) break;
      tool_ = in_scene(hand);
      hand_ = hand;
      state_ = Tool::halted;
      break;
    case Tool::halted:
      hand_ = hand;
      state_ = Tool::standing;
      break;
    case Tool::standing:
      hand_ = hand;
      if (!reading.clutch) state_ = Tool::led;
      break;
  }
  reading.pose = in_scene(hand);
  reading.clutched = state_ == Tool::standing;
}

DeviceReading MappedDevice::read(Nanoseconds now) noexcept {
  DeviceReading reading = device_->read(now);
  const bool held = reading.held && *reading.held != Command{};
  if (reading.held) reading.held = to_scene(*reading.held);
  if (reading.ok && reading.fresh) clutch(reading, held || !command_delay_.nothing_left());
  return reading;
}

Command MappedDevice::write(const Command& on_hand) noexcept {
  const Command asked = state_ == Tool::led ? to_device(on_hand) : Command{};
  const Command given = actuated(device_->spec(), asked);
  const Command held = device_->write(given);
  command_delay_.written(given, held);
  // Return a fully held command itself, so that it has no rounding error.
  return held == asked && state_ == Tool::led ? on_hand : to_scene(held);
}

}  // namespace feltwire
