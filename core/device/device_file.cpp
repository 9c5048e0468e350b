#include "core/device/device_file.hpp"

#include <string>

#include "core/base/json_document.hpp"
#include "core/device/device_spec_generated.h"
#include "core/device/device_spec_text.hpp"

namespace feltwire {
namespace {

using Numbers = flatbuffers::Vector<double>;

/// Three numbers along x, y, z, or nine of a symmetric matrix.
Mat3 matrix(const JsonDocument& document, const char* field, const Numbers& values) {
  constexpr flatbuffers::uoffset_t kAxes = 3, kMatrix = 9;
  if (values.size() == kAxes) {
    for (const double value : values)
      if (!(value >= 0.0)) document.fail(field, "must be zero or more; check the sign");
    return Vec3(values[0], values[1], values[2]).asDiagonal();
  }
  if (values.size() != kMatrix)
    document.fail(field, "give three numbers, along x, y and z, or the nine of a symmetric matrix");
  return Eigen::Map<const Mat3>(values.data());
}

Damping damping(const JsonDocument& document, const char* field, const Numbers* values) {
  if (values == nullptr) return 0.0;
  if (values->size() == 1) {
    if (!(values->Get(0) >= 0.0)) document.fail(field, "must be zero or more; check the sign");
    return values->Get(0);
  }
  return matrix(document, field, *values);
}

/// The least in any direction of what one field gives as a number, or another as a matrix.
double least(const JsonDocument& document, const std::string& field, double number,
             const Numbers* values) {
  if (values == nullptr) return number;
  const std::string other = field + "_matrix";
  if (document.has(field))
    document.fail(other, "stands beside " + field + ", which says the same; give one of the two");
  const Damping given(matrix(document, other.c_str(), *values));  // checked as a damping is
  try {
    validate(given, other.c_str());
  } catch (const std::invalid_argument& error) {
    document.fail(other, error.what());
  }
  return given.least();
}

}  // namespace

DeviceSpec load_device_spec(const std::filesystem::path& file) {
  const JsonDocument document(read_text(file), file.string(), embedded::device_spec);
  const auto& given = *device_file::GetDeviceSpec(document.buffer());
  if (given.workspace()->size() != 3)
    document.fail("workspace", "give three numbers, the extent along x, y and z [m]");
  DeviceSpec spec{
      .name = given.name()->str(),
      .translation_dof = given.translation_dof(),
      .rotation_sensed = given.rotation_sensed(),
      .rotation_actuated = given.rotation_actuated(),
      .damping = damping(document, "damping", given.damping()),
      .rotational_damping = damping(document, "rotational_damping", given.rotational_damping()),
      .apparent_mass = given.apparent_mass(),
      .coulomb_friction = given.coulomb_friction(),
      .position_resolution = given.position_resolution(),
      .max_force = given.max_force(),
      .continuous_force =
          given.continuous_force() < 0.0 ? given.max_force() : given.continuous_force(),
      .max_torque = given.max_torque(),
      .workspace =
          Vec3(given.workspace()->Get(0), given.workspace()->Get(1), given.workspace()->Get(2)),
      .least_mass = least(document, "least_mass", given.least_mass(), given.least_mass_matrix()),
      .least_friction = given.least_friction(),
      .hand_force = given.hand_force(),
      .hand_speed = given.hand_speed(),
      .rotational_resolution = given.rotational_resolution(),
      .least_inertia =
          least(document, "least_inertia", given.least_inertia(), given.least_inertia_matrix()),
      .hand_torque = given.hand_torque()};
  try {
    validate(spec);
  } catch (const DeviceSpecError& error) {
    document.fail(error.field, error.why);
  }
  return spec;
}

DeviceSpec device_spec(std::string_view name_or_file) {
  return name_or_file.ends_with(".json") ? load_device_spec(name_or_file)
                                         : builtin_device(name_or_file);
}

}  // namespace feltwire
