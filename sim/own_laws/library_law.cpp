#include "sim/own_laws/library_law.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "client/drivers/common/shared_library.hpp"
#include "sim/own_laws/feltwire_law_v1.h"
#include "sim/own_laws/own_law.hpp"

namespace feltwire {
namespace {

static_assert(kOwnLawMemory == FELTWIRE_LAW_LARGEST_STATE);
static_assert(FELTWIRE_PROMISE_OWN_SUM == static_cast<int>(Promise::own_sum));

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw std::runtime_error("law " + file.string() + ": " + why);
}

void write(const Vec3& v, double (&to)[3]) { std::copy_n(v.data(), 3, to); }

feltwire_law_force_v1 c_force(const Command& c) {
  feltwire_law_force_v1 force{};
  write(c.elastic, force.elastic);
  write(c.frictional, force.frictional);
  write(c.torque, force.torque);
  return force;
}

feltwire_law_device_v1 c_device(const BoundingConfig& config) {
  feltwire_law_device_v1 device{};
  device.period = config.period;
  device.lag = config.lag;
  device.least_damping = config.damping.least();
  device.least_rotational_damping = config.rotational_damping.least();
  device.max_force = config.max_force;
  device.max_torque = config.max_torque;
  device.rotation = config.rotation ? 1 : 0;
  // The matrices are symmetric: by rows is by columns.
  std::copy_n(config.damping.matrix().data(), 9, device.damping);
  std::copy_n(config.rotational_damping.matrix().data(), 9, device.rotational_damping);
  return device;
}

class LibraryLaw final : public OwnLaw {
 public:
  LibraryLaw(SharedLibrary library, const feltwire_law_v1& functions)
      : library_(std::move(library)), functions_(functions) {}

  void reset(const BoundingConfig& config, std::byte* memory) override {
    const feltwire_law_device_v1 device = c_device(config);
    if (functions_.reset(memory, &device) != 0)
      throw std::invalid_argument("law " + std::string(functions_.name) +
                                  ": reset() refuses this device; judge it with another one");
  }
  Command step(std::byte* memory, const BoundingStep& s) override {
    feltwire_law_step_v1 step{};
    step.hold_time = s.hold_time;
    step.command = c_force(s.command);
    step.local = s.local ? 1 : 0;
    write(s.displacement, step.displacement);
    write(s.rotation, step.rotation);
    feltwire_law_force_v1 rendered{};
    functions_.step(memory, &step, &rendered);
    return {Vec3(rendered.elastic), Vec3(rendered.frictional), Vec3(rendered.torque)};
  }
  void set_held(std::byte* memory, const Command& held) override {
    const feltwire_law_force_v1 force = c_force(held);
    functions_.set_held(memory, &force);
  }

 private:
  SharedLibrary library_;  // stays loaded
  const feltwire_law_v1& functions_;
};

SharedLibrary load(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file))
    refuse(file, "there is no such file; give the path of a shared library");
  try {
    return SharedLibrary(std::filesystem::absolute(file));
  } catch (const std::runtime_error& error) {
    refuse(file, std::string("it cannot be loaded: ") + error.what() +
                     "; build it as a shared library for this machine (cc -shared -fPIC)");
  }
}

const feltwire_law_v1& functions_of(const SharedLibrary& library) {
  const std::filesystem::path& file = library.file();
  auto* entry = library.find<const feltwire_law_v1*()>("feltwire_law");
  if (entry == nullptr)
    refuse(file, "it exports no function feltwire_law(); declare it as feltwire_law_v1.h does");
  const feltwire_law_v1* law = entry();
  if (law == nullptr) refuse(file, "feltwire_law() returned null");
  if (law->version != FELTWIRE_LAW_VERSION)
    refuse(file, "it speaks version " + std::to_string(law->version) +
                     " of the ABI, this program " + std::to_string(FELTWIRE_LAW_VERSION) +
                     "; build it against this program's feltwire_law_v1.h");
  if (law->size < sizeof(feltwire_law_v1))
    refuse(file, "its table has " + std::to_string(law->size) + " bytes, not " +
                     std::to_string(sizeof(feltwire_law_v1)) +
                     " or more; set size to sizeof(feltwire_law_v1)");
  const std::pair<const char*, bool> needed[] = {{"name", law->name != nullptr},
                                                 {"reset", law->reset != nullptr},
                                                 {"step", law->step != nullptr},
                                                 {"set_held", law->set_held != nullptr}};
  for (const auto& [name, there] : needed)
    if (!there) refuse(file, std::string("its ") + name + " is null; fill it in");
  if (law->state_size > kOwnLawMemory)
    refuse(file, "its state has " + std::to_string(law->state_size) + " bytes; at most " +
                     std::to_string(kOwnLawMemory) + " are kept for it");
  if ((law->kept_despite & ~FELTWIRE_KEPT_ALL) != 0)
    refuse(file, "its kept_despite is " + std::to_string(law->kept_despite) +
                     "; add up FELTWIRE_KEPT_... of this program's feltwire_law_v1.h");
  return *law;
}

Promise promise_of(const std::filesystem::path& file, std::int32_t number) {
  for (const Promise p : {Promise::none, Promise::port, Promise::port_by_axis,
                          Promise::own_sum_by_axis, Promise::own_sum})
    if (number == static_cast<std::int32_t>(p)) return p;
  refuse(file, "its promise is " + std::to_string(number) + "; give one of FELTWIRE_PROMISE_...");
}

}  // namespace

void add_library_law(const std::filesystem::path& file) {
  SharedLibrary library = load(file);
  const feltwire_law_v1& law = functions_of(library);
  const OwnLawEntry entry{
      .name = law.name,
      .summary = law.summary != nullptr ? law.summary : "",
      .promise = promise_of(file, law.promise),
      .kept_despite = {.overlong_holds = (law.kept_despite & FELTWIRE_KEPT_OVERLONG_HOLDS) != 0,
                       .reductions = (law.kept_despite & FELTWIRE_KEPT_REDUCTIONS) != 0,
                       .unknown_inputs = (law.kept_despite & FELTWIRE_KEPT_UNKNOWN_INPUTS) != 0},
      .admits_reduction = law.admits_reduction != 0};
  add_own_law(entry, std::make_unique<LibraryLaw>(std::move(library), law));
}

}  // namespace feltwire
