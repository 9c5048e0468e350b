#include "core/device/device_file.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/base/enum_names.hpp"
#include "core/base/json_document.hpp"
#include "core/device/delta_3_text.hpp"
#include "core/device/device_spec_generated.h"
#include "core/device/device_spec_text.hpp"
#include "core/device/falcon_text.hpp"
#include "core/device/hapi_2dof_text.hpp"
#include "core/device/impulse_engine_2000_text.hpp"
#include "core/device/inverse3_text.hpp"
#include "core/device/lambda_7_text.hpp"
#include "core/device/omega_7_text.hpp"
#include "core/device/phantom_premium_1_5_6dof_text.hpp"
#include "core/device/phantom_premium_1_5_text.hpp"
#include "core/device/sigma_7_text.hpp"
#include "core/device/simulated_6dof_text.hpp"
#include "core/device/simulated_text.hpp"
#include "core/device/spec_names.hpp"
#include "core/device/touch_text.hpp"
#include "core/device/virtuose_6d_text.hpp"

namespace feltwire {
namespace {

using Numbers = flatbuffers::Vector<double>;

/// Reads three numbers along x, y, z, or the nine numbers of a symmetric matrix.
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
  const Mat3 given = matrix(document, field, *values);
  return values->size() == 3 ? Damping(Vec3(given.diagonal())) : Damping(given);
}

void require_alone(const JsonDocument& document, const std::string& several,
                   const std::string& field) {
  if (document.has(field))
    document.fail(several, "stands beside " + field + ", which says the same; give one of the two");
}

/// Returns the least value over all directions. The file has a number in `field`, or a matrix in
/// the field with the suffix _matrix.
double least(const JsonDocument& document, const std::string& field, double number,
             const Numbers* values) {
  if (values == nullptr) return number;
  const std::string other = field + "_matrix";
  require_alone(document, other, field);
  // Use the checks of a damping matrix.
  const Damping given(matrix(document, other.c_str(), *values));
  try {
    validate(given, other.c_str());
  } catch (const std::invalid_argument& error) {
    document.fail(other, error.what());
  }
  return given.least();
}

/// Returns the largest lag. The file has a number, or the lags of the motors of force or of force
/// and torque.
double largest_lag(const JsonDocument& document, double number, const Numbers* values) {
  if (values == nullptr) return number;
  constexpr const char* kSeveral = "actuation_lags";
  constexpr flatbuffers::uoffset_t kForce = 3, kWrench = 6;
  require_alone(document, kSeveral, "actuation_lag");
  if (values->size() != kForce && values->size() != kWrench)
    document.fail(kSeveral, "give three numbers, along x, y and z, or six, also about them");
  double largest = 0.0;
  for (const double value : *values) {
    if (!(value >= 0.0)) document.fail(kSeveral, "must be zero or more; check the sign");
    largest = std::max(largest, value);
  }
  return largest;
}

LagKind lag_kind(const JsonDocument& document, const flatbuffers::String* name) {
  if (name == nullptr) return LagKind::delay;
  return document.choice<LagKind>("actuation_kind", name->string_view(), kLagKindNames);
}

EncoderSide encoder_side(const JsonDocument& document, const flatbuffers::String* name) {
  if (name == nullptr) return EncoderSide::motor;
  return document.choice<EncoderSide>("encoder_side", name->string_view(), kEncoderSideNames);
}

SpecSources sources_of(const device_file::DeviceSpec& given) {
  SpecSources sources;
  const auto* said = given.sources();
  if (said == nullptr) return sources;
  using FileSources = device_file::Sources;
  constexpr std::pair<const char*, const flatbuffers::String* (FileSources::*)() const> kFields[] =
      {
          {"translation_dof", &FileSources::translation_dof},
          {"rotation_sensed", &FileSources::rotation_sensed},
          {"rotation_actuated", &FileSources::rotation_actuated},
          {"damping", &FileSources::damping},
          {"rotational_damping", &FileSources::rotational_damping},
          {"apparent_mass", &FileSources::apparent_mass},
          {"coulomb_friction", &FileSources::coulomb_friction},
          {"position_resolution", &FileSources::position_resolution},
          {"max_force", &FileSources::max_force},
          {"continuous_force", &FileSources::continuous_force},
          {"max_torque", &FileSources::max_torque},
          {"workspace", &FileSources::workspace},
          {"least_mass", &FileSources::least_mass},
          {"least_friction", &FileSources::least_friction},
          {"hand_force", &FileSources::hand_force},
          {"hand_speed", &FileSources::hand_speed},
          {"late_ticks", &FileSources::late_ticks},
          {"actuation_lag", &FileSources::actuation_lag},
          {"actuation_kind", &FileSources::actuation_kind},
          {"transmission_stiffness", &FileSources::transmission_stiffness},
          {"encoder_side", &FileSources::encoder_side},
          {"rotational_resolution", &FileSources::rotational_resolution},
          {"least_inertia", &FileSources::least_inertia},
          {"hand_torque", &FileSources::hand_torque},
          {"apparent_inertia", &FileSources::apparent_inertia},
          {"rotational_friction", &FileSources::rotational_friction},
      };
  for (const auto& [field, source] : kFields)
    if (const auto* text = (said->*source)()) sources[field] = text->str();
  return sources;
}

SourcedSpec read_spec(std::string_view text, std::string file) {
  const JsonDocument document(text, std::move(file), embedded::device_spec);
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
      .actuation = {.late_ticks = given.late_ticks(),
                    .lag = largest_lag(document, given.actuation_lag(), given.actuation_lags()),
                    .kind = lag_kind(document, given.actuation_kind())},
      .transmission = {.stiffness =
                           least(document, "transmission_stiffness", given.transmission_stiffness(),
                                 given.transmission_stiffness_matrix()),
                       .encoder_side = encoder_side(document, given.encoder_side())},
      .rotation = {.resolution = given.rotational_resolution(),
                   .least_inertia = least(document, "least_inertia", given.least_inertia(),
                                          given.least_inertia_matrix()),
                   .hand_torque = given.hand_torque(),
                   .inertia = given.apparent_inertia(),
                   .friction = given.rotational_friction()}};
  try {
    validate(spec);
  } catch (const DeviceSpecError& error) {
    document.fail(error.field, error.why);
  }
  return {std::move(spec), sources_of(given),
          document.has("actuation_lag") || document.has("actuation_lags"),
          document.has("transmission_stiffness") || document.has("transmission_stiffness_matrix")};
}

/// Returns the built-in devices, in a fixed order.
const std::vector<SourcedSpec>& built_in() {
  static const std::vector<SourcedSpec> list = [] {
    std::vector<SourcedSpec> specs;
    for (const char* text :
         {embedded::simulated, embedded::impulse_engine_2000, embedded::phantom_premium_1_5,
          embedded::touch, embedded::omega_7, embedded::sigma_7, embedded::virtuose_6d,
          embedded::phantom_premium_1_5_6dof, embedded::simulated_6dof, embedded::delta_3,
          embedded::lambda_7, embedded::falcon, embedded::inverse3, embedded::hapi_2dof})
      specs.push_back(read_spec(text, "a built-in device"));
    return specs;
  }();
  return list;
}

}  // namespace

std::vector<std::string> device_spec_names() {
  std::vector<std::string> names;
  for (const SourcedSpec& known : built_in()) names.push_back(known.spec.name);
  return names;
}

SourcedSpec load_sourced_spec(const std::filesystem::path& file) {
  return read_spec(read_text(file), file.string());
}

std::span<const DeviceSpec> builtin_devices() {
  static const std::vector<DeviceSpec> list = [] {
    std::vector<DeviceSpec> specs;
    for (const SourcedSpec& one : built_in()) specs.push_back(one.spec);
    return specs;
  }();
  return list;
}

const DeviceSpec& builtin_device(std::string_view name) {
  return get_named("device", name, builtin_devices(), &DeviceSpec::name);
}

std::span<const SourcedSpec> sourced_builtin_devices() { return built_in(); }

SourcedSpec sourced_spec(std::string_view name_or_file) {
  if (name_or_file.ends_with(".json")) return load_sourced_spec(name_or_file);
  const auto name = [](const SourcedSpec& one) -> const std::string& { return one.spec.name; };
  return get_named("device", name_or_file, built_in(), name);
}

DeviceSpec device_spec(std::string_view name_or_file) { return sourced_spec(name_or_file).spec; }

SourcedSpec requested_spec(const SpecRequest& request, std::string_view usual) {
  SourcedSpec found =
      sourced_spec(request.name_or_file.empty() ? usual : std::string_view(request.name_or_file));
  return overruled(std::move(found), request);
}

SourcedSpec overruled(SourcedSpec found, const SpecRequest& request) {
  if (request.damping) {
    found.spec.damping = *request.damping;
    found.sources["damping"] = "damping of --device";
  }
  if (request.mass) {
    found.spec.apparent_mass = found.spec.least_mass = *request.mass;
    found.sources["apparent_mass"] = found.sources["least_mass"] = "mass of --device";
  }
  validate(found.spec);
  return found;
}

}  // namespace feltwire
