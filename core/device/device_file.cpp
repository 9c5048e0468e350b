#include "core/device/device_file.hpp"

#include <string>

#include "core/base/json_document.hpp"
#include "core/device/device_spec_generated.h"
#include "core/device/device_spec_text.hpp"

namespace feltwire {
namespace {

using Numbers = flatbuffers::Vector<double>;

Damping damping(const JsonDocument& document, const char* field, const Numbers* values) {
  if (values == nullptr) return 0.0;
  for (const double value : *values)
    if (!(value >= 0.0)) document.fail(field, "must be zero or more; check the sign");
  if (values->size() == 1) return values->Get(0);
  if (values->size() != 3) document.fail(field, "give one number, or three along x, y and z");
  return Damping(Mat3(Vec3(values->Get(0), values->Get(1), values->Get(2)).asDiagonal()));
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
      .least_mass = given.least_mass(),
      .least_friction = given.least_friction(),
      .hand_force = given.hand_force()};
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
