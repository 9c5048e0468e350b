#include "client/app/rival_options.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

#include "client/command_line/credential_options.hpp"
#include "client/drivers/drivers.hpp"
#include "core/bounding/method.hpp"
#include "core/recording/recording_files.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {
namespace {

using Value = std::string_view;

/// Returns whether CLI11 reads this value of a flag as false.
bool says_no(Value value) {
  constexpr std::array<Value, 5> kNo = {"false", "off", "no", "disable", "0"};
  return std::find(kNo.begin(), kNo.end(), value) != kNo.end();
}
bool says_yes(Value value) { return !says_no(value); }

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

/// Returns the method of a --mode value, or null if there is none. The option's parser reports the
/// error.
const BoundingMethod* method_of(Value mode) {
  for (const BoundingMethod* method : bounding_methods())
    if (method->name == mode) return method;
  return nullptr;
}

bool for_side(Value mode, BoundingSide side) {
  const BoundingMethod* method = method_of(mode);
  if (method == nullptr) return true;
  if (method->shapes) return side == BoundingSide::client;
  return !stands_beside_scene(*method) || side == BoundingSide::server;
}

bool for_client(Value mode) { return for_side(mode, BoundingSide::client); }
bool for_server(Value mode) { return for_side(mode, BoundingSide::server); }
bool for_both(Value mode) { return for_side(mode, BoundingSide::both); }

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
  Rivals rivals = {
      {"device", "firmware", [](Value d) { return driver_of(d) && !driver_of(d)->takes_firmware; }},
      // A check uses its own simulated hand, so these options do not apply.
      {"check", "device"},
      {"check", "firmware"}};
  return rivals;
}

/// Returns the option conflicts of the side (client, server or both) and the method of the force
/// bound.
Rivals of_bounds() {
  const auto paper = [](Value mode) { return for_client(mode) && for_server(mode); };
  Rivals rivals = {{"bounding", "mode", is("client"), for_client},
                   {"bounding", "mode", is("server"), for_server},
                   {"bounding", "mode", is("both"), for_both},
                   {"bounding", "local-model", is("server"), says_no},
                   {"bounding", "no-account", is("server"), says_no},
                   {"mode", "bounding", [](Value mode) { return !for_server(mode); }, is("client")},
                   {"mode", "bounding", [](Value mode) { return !for_client(mode); }, is("server")},
                   {"mode", "no-account", [=](Value mode) { return !paper(mode); }, says_no},
                   {"local-model", "bounding", says_yes, is_not("server")},
                   {"local-model", "mode", says_yes, for_client},
                   {"mode", "local-model", [](Value mode) { return !for_client(mode); }, says_no},
                   {"no-account", "bounding", {}, is_not("server")},
                   {"no-account", "operator-damping"},
                   {"operator-damping", "no-account", {}, says_no},
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
                   {"lead", "bounding", {}, is_not("server")},
                   {"lead", "local-model", {}, says_yes},
                   {"role", "view", is_not("observer")}};
  // These options need a hand that leads a robot, with the local model at the client.
  for (const char* option : {"lead", "robot", "trust-robot"}) {
    rivals.push_back({"role", option, is("observer")});
    rivals.push_back({"local-model", option, says_no});
    rivals.push_back({"bounding", option, is("server")});
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
