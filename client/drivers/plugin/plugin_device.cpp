#include "client/drivers/plugin/plugin_device.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "client/device/assumed_transmission.hpp"
#include "client/device/connection_lag.hpp"
#include "client/device/held_command.hpp"
#include "client/drivers/common/shared_library.hpp"
#include "client/drivers/plugin/feltwire_device_v1.h"
#include "core/device/spec_text.hpp"

namespace feltwire {
namespace plugin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEntry = "feltwire_device";

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw std::runtime_error("plugin " + file.string() + ": " + why);
}

SharedLibrary load(const fs::path& file) {
  if (!fs::is_regular_file(file))
    refuse(file, "there is no such file; check the path behind 'plugin:'");
  try {
    return SharedLibrary(fs::absolute(file));
  } catch (const std::runtime_error& error) {
    refuse(file, std::string("it cannot be loaded: ") + error.what() +
                     "; build it as a shared library for this machine (cc -shared -fPIC)");
  }
}

/// Returns the function table of the plugin. Throws if a required function is missing.
const feltwire_device_v1& functions(const SharedLibrary& library) {
  const fs::path& file = library.file();
  auto* entry = library.find<const feltwire_device_v1*()>(kEntry);
  if (entry == nullptr)
    refuse(file, std::string("it exports no function ") + kEntry +
                     "(); declare it as feltwire_device_v1.h does");
  const feltwire_device_v1* table = entry();
  if (table == nullptr) refuse(file, std::string(kEntry) + "() returned null");
  if (table->version != FELTWIRE_DEVICE_VERSION)
    refuse(file, "it speaks version " + std::to_string(table->version) +
                     " of the ABI, this client " + std::to_string(FELTWIRE_DEVICE_VERSION) +
                     "; build it against this client's feltwire_device_v1.h");
  // Plugins that were built with an older header have a shorter table.
  constexpr std::size_t kShortest = offsetof(feltwire_device_v1, actuation_lag);
  if (table->size < kShortest)
    refuse(file, "its table of functions has " + std::to_string(table->size) + " bytes, not " +
                     std::to_string(kShortest) +
                     " or more; set size to sizeof(feltwire_device_v1)");
  const std::pair<const char*, bool> needed[] = {{"open", table->open != nullptr},
                                                 {"read", table->read != nullptr},
                                                 {"write", table->write != nullptr},
                                                 {"release", table->release != nullptr},
                                                 {"close", table->close != nullptr}};
  for (const auto& [name, there] : needed)
    if (!there) refuse(file, std::string("its function ") + name + " is null; fill it in");
  return *table;
}

Vec3 vector(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

DeviceSpec spec_of(const feltwire_spec_v1& given) {
  const auto length = std::find(std::begin(given.name), std::end(given.name), '\0');
  const Vec3 b = vector(given.damping);
  return {
      .name = std::string(std::begin(given.name), length),
      .translation_dof = given.translation_dof,
      .rotation_sensed = given.rotation_sensed,
      .rotation_actuated = given.rotation_actuated,
      .damping = b == Vec3::Constant(b.x()) ? Damping(b.x()) : Damping(b),
      .rotational_damping = given.rotational_damping,
      .apparent_mass = given.apparent_mass,
      .coulomb_friction = given.coulomb_friction,
      .position_resolution = given.position_resolution,
      .max_force = given.max_force,
      .continuous_force = given.continuous_force > 0.0 ? given.continuous_force : given.max_force,
      .max_torque = given.max_torque,
      .workspace = vector(given.workspace),
      .least_mass = given.least_mass,
      .least_friction = given.least_friction,
      .hand_force = given.hand_force,
      .hand_speed = given.hand_speed,
      .actuation = {.late_ticks = given.late_ticks},
      .rotation = {.resolution = given.rotational_resolution,
                   .least_inertia = given.least_inertia,
                   .hand_torque = given.hand_torque}};
}

SpecSources sources_of(const feltwire_spec_v1& given) {
  const std::string source =
      given.source != nullptr ? given.source : "assumption: the plugin tells no source";
  SpecSources sources;
  for (const char* field : {"damping", "apparent_mass", "coulomb_friction", "position_resolution",
                            "max_force", "continuous_force", "workspace"})
    sources[field] = source;
  if (given.least_mass > 0.0) sources["least_mass"] = source;
  if (given.least_friction > 0.0) sources["least_friction"] = source;
  if (given.least_inertia > 0.0) sources["least_inertia"] = source;
  return sources;
}

/// Sets the actuation lag of the specification, if the plugin reports it.
void tell_lag(const fs::path& file, const feltwire_device_v1& table, void* device,
              SourcedSpec& described, const std::string& source) {
  constexpr std::size_t kWithLag = offsetof(feltwire_device_v1, transmission);
  if (table.size < kWithLag || table.actuation_lag == nullptr) return;
  double lag = 0.0;
  std::int32_t kind = FELTWIRE_LAG_DELAY;
  if (table.actuation_lag(device, &lag, &kind) == 0) return;
  constexpr std::array kKinds = {LagKind::delay, LagKind::filter, LagKind::mixed};
  if (kind < 0 || kind >= static_cast<std::int32_t>(kKinds.size()))
    refuse(file, "actuation_lag() sets the kind " + std::to_string(kind) +
                     "; set FELTWIRE_LAG_DELAY, FELTWIRE_LAG_FILTER or FELTWIRE_LAG_MIXED");
  described.spec.actuation.lag = lag;
  described.spec.actuation.kind = kKinds[static_cast<std::size_t>(kind)];
  described.tells_lag = true;
  described.sources["actuation_lag"] = source;
}

/// Sets the transmission of the specification, if the plugin reports it.
void tell_transmission(const fs::path& file, const feltwire_device_v1& table, void* device,
                       SourcedSpec& described, const std::string& source) {
  if (table.size < sizeof(feltwire_device_v1) || table.transmission == nullptr) return;
  double stiffness = 0.0;
  std::int32_t side = FELTWIRE_ENCODER_MOTOR;
  if (table.transmission(device, &stiffness, &side) == 0) return;
  if (side != FELTWIRE_ENCODER_MOTOR && side != FELTWIRE_ENCODER_HANDLE)
    refuse(file, "transmission() sets the encoder's side " + std::to_string(side) +
                     "; set FELTWIRE_ENCODER_MOTOR or FELTWIRE_ENCODER_HANDLE");
  described.spec.transmission.stiffness = stiffness;
  described.spec.transmission.encoder_side =
      side == FELTWIRE_ENCODER_HANDLE ? EncoderSide::handle : EncoderSide::motor;
  described.tells_transmission = true;
  described.sources["transmission_stiffness"] = source;
  described.sources["encoder_side"] = source;
}

class PluginDevice final : public Device {
 public:
  PluginDevice(SharedLibrary library, const std::string& arguments)
      : library_(std::move(library)), functions_(functions(library_)) {
    feltwire_spec_v1 given{};
    given.hand_force = DeviceSpec{}.hand_force;
    std::array<char, 512> error{};
    device_ = functions_.open(arguments.c_str(), &given, error.data(), error.size());
    error.back() = '\0';
    if (device_ == nullptr)
      refuse(library_.file(), error.front() != '\0'
                                  ? error.data()
                                  : "open() failed without a reason; let open() write one");
    try {
      const double longest = given.longest_tick;
      if (!std::isfinite(longest) || longest < 0.0)
        refuse(library_.file(), "longest_tick must be 0, or above 0 [s]");
      if (longest > 0.0 && functions_.wait == nullptr)
        refuse(library_.file(), "longest_tick is set, and its function wait is null; fill it in");
      longest_tick_ = from_seconds(longest);
      described_ = {spec_of(given), sources_of(given)};
      const std::string source = described_.sources["damping"];
      tell_lag(library_.file(), functions_, device_, described_, source);
      tell_transmission(library_.file(), functions_, device_, described_, source);
      validate(described_.spec);
    } catch (...) {
      close();
      throw;
    }
  }
  ~PluginDevice() override { close(); }
  PluginDevice(const PluginDevice&) = delete;
  PluginDevice& operator=(const PluginDevice&) = delete;

  const SourcedSpec& described() const { return described_; }
  void describe(SourcedSpec described) { described_ = std::move(described); }

  const DeviceSpec& spec() const override { return described_.spec; }
  Nanoseconds longest_tick() const override { return longest_tick_; }

  bool await_tick(Nanoseconds latest) noexcept override {
    return functions_.wait(device_, latest.count()) != 0;
  }

  DeviceReading read(Nanoseconds) noexcept override {
    feltwire_reading_v1 told{};
    told.orientation[0] = 1.0;
    DeviceReading reading;
    switch (functions_.read(device_, &told)) {
      case FELTWIRE_OK:
        break;
      case FELTWIRE_STALE:
        reading.fresh = false;
        return reading;
      case FELTWIRE_ENDED:
        reading.ended = true;
        [[fallthrough]];
      default:
        reading.ok = false;
        return reading;
    }
    reading.pose.position = vector(told.position);
    reading.pose.orientation = Quaternion(told.orientation[0], told.orientation[1],
                                          told.orientation[2], told.orientation[3]);
    reading.buttons = told.buttons;
    reading.deadman = (told.buttons & 1u) != 0;
    reading.clutch = (told.buttons & 2u) != 0;
    if (told.has_lever != 0) reading.gripper = told.lever;
    if (told.tells_held != 0)
      reading.held = held_command(written_, vector(told.held_force), vector(told.held_torque));
    return reading;
  }

  Command write(const Command& on_hand) noexcept override {
    written_ = on_hand;
    const Vec3 force = on_hand.force(), &torque = on_hand.torque;
    double held_force[3] = {force.x(), force.y(), force.z()};
    double held_torque[3] = {torque.x(), torque.y(), torque.z()};
    if (functions_.write(device_, force.data(), torque.data(), held_force, held_torque) != 0)
      return {};
    return held_command(on_hand, vector(held_force), vector(held_torque));
  }

  void release() noexcept override { functions_.release(device_); }

 private:
  void close() noexcept {
    functions_.release(device_);
    functions_.close(device_);
  }

  SharedLibrary library_;
  const feltwire_device_v1& functions_;
  void* device_ = nullptr;
  SourcedSpec described_;
  Nanoseconds longest_tick_{0};
  Command written_;
};

}  // namespace
}  // namespace plugin

OpenedDevice open_plugin(const DeviceRequest& request) {
  const std::size_t colon = request.name.find(':');
  const std::filesystem::path file = request.name.substr(0, colon);
  const std::string arguments =
      colon == std::string::npos ? std::string() : request.name.substr(colon + 1);
  auto device = std::make_unique<plugin::PluginDevice>(plugin::load(file), arguments);
  SourcedSpec described = request.spec.name_or_file.empty()
                              ? overruled(device->described(), request.spec)
                              : requested_spec(request.spec, "");
  assume_lag(described, kUnknownConnection);
  assume_transmission(described, kUnknownDrive);
  device->describe(std::move(described));
  std::vector<std::string> notes = assumptions(device->described());
  return {std::move(device), std::move(notes)};
}

}  // namespace feltwire
