#include "client/app/rival_options.hpp"

#include <cmath>
#include <cstdlib>
#include <string>

#include "client/command_line/credential_options.hpp"
#include "client/drivers/drivers.hpp"
#include "core/bounding/method.hpp"
#include "core/recording/recording_files.hpp"
#include "protocol/command_line/settings.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {
namespace {

using Value = std::string_view;

auto is(const char* wanted) {
  return [wanted](Value value) { return value == wanted; };
}
auto is_not(const char* wanted) {
  return [wanted](Value value) { return value != wanted; };
}

/// Returns the driver of a --device value, or null if there is none. The option's parser reports
/// the error.
const Driver* driver_of(Value device) {
  const Value kind = device.substr(0, device.find(':'));
  for (const Driver& driver : drivers())
    if (driver.kind == kind) return &driver;
  return nullptr;
}

/// Returns the method of a --mode value, or null if it names none. The option's parser reports the
/// error.
const BoundingMethod* method_of(Value mode) {
  const Value name = mode.substr(0, mode.find(','));
  for (const BoundingMethod* method : bounding_methods())
    if (method->name == name) return method;
  return nullptr;
}

/// Returns whether the server alone bounds with this value of --mode.
bool bounds_at_server(Value mode) {
  if (const auto side = setting_in(mode, "side")) return *side == "server";
  const BoundingMethod* method = method_of(mode);
  return method != nullptr && stands_beside_scene(*method);
}
bool bounds_at_client(Value mode) { return !bounds_at_server(mode); }

/// Returns whether the number is a limit. "inf" and 0 mean no limit.
bool limits(Value number) {
  const double value = std::strtod(std::string(number).c_str(), nullptr);
  return std::isfinite(value) && value > 0.0;
}

bool admits_limits(Value mode) {
  const BoundingMethod* method = method_of(mode);
  return method == nullptr || method->admits_reduction;
}

/// Returns the option conflicts of the device kind: some options work only with some devices.
Rivals of_devices() {
  // A check uses its own simulated hand.
  Rivals rivals = {{"check", "device"}};
  return rivals;
}

/// Returns the option conflicts of the bound: its side, its method and the local model.
Rivals of_bounds() {
  Rivals rivals = {{"mode", "local-model", bounds_at_server, is("off")},
                   {"local-model", "mode", is_not("off"), bounds_at_client},
                   // Some methods do not admit these further limits on the bounded force.
                   {"slew", "mode", limits, admits_limits},
                   {"ramp-up", "mode", limits, admits_limits},
                   {"velocity-limit", "mode", limits, admits_limits}};
  return rivals;
}

/// Returns the option conflicts of roles: only a hand leads a robot, and an observer only watches.
Rivals of_roles() {
  Rivals rivals = {{"lead", "role"},
                   {"lead", "view"},
                   {"lead", "mode", {}, bounds_at_client},
                   {"lead", "local-model", {}, is_not("off")},
                   {"role", "view", is_not("observer")}};
  // These options need a hand that leads a robot, with the local model at the client.
  for (const char* option : {"lead", "robot", "trust-robot"}) {
    rivals.push_back({"role", option, is("observer")});
    rivals.push_back({"local-model", option, is("off")});
    rivals.push_back({"mode", option, bounds_at_server});
    rivals.push_back({"check", option});
  }
  return rivals;
}

/// Returns the option conflicts of an admin's changes: which of them are possible depends on
/// whether a person may hold the device.
Rivals of_changes() {
  const auto held = [](Value device) {
    return driver_of(device) && driver_of(device)->held_by_person;
  };
  Rivals rivals = {{"device", "changes", held, is_not("any")}};
  return rivals;
}

/// Returns the option conflicts of recordings: only MCAP recordings support file limits.
Rivals of_recordings() {
  const auto one_file = [](Value file) { return !is_mcap(std::string(file)); };
  Rivals rivals = {{"record", "record-max-mib", one_file},
                   {"record", "record-max-seconds", one_file}};
  return rivals;
}

}  // namespace

Rivals client_rivals() {
  Rivals all = credential_rivals();
  for (const Rivals& some : {of_devices(), of_bounds(), of_roles(), of_changes(), of_recordings()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace feltwire
