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

/// True for a flag value that CLI11 reads as false.
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

/// Returns null for an unknown driver. The parser of the option reports the error.
const Driver* driver_of(Value device) {
  const Value kind = device.substr(0, device.find(':'));
  for (const Driver& driver : drivers())
    if (driver.kind == kind) return &driver;
  return nullptr;
}

/// Returns null for an unknown method. The parser of the option reports the error.
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

/// False for "inf" and 0, because they mean no limit.
bool limits(Value number) {
  const double value = std::strtod(std::string(number).c_str(), nullptr);
  return std::isfinite(value) && value > 0.0;
}

bool admits_limits(Value mode) {
  const BoundingMethod* method = method_of(mode);
  return method == nullptr || method->admits_reduction;
}

/// Rules for the kind of device, and for options that only some devices support.
Rivals of_devices() {
  Rivals rivals = {
      {"device", "firmware", [](Value d) { return driver_of(d) && !driver_of(d)->takes_firmware; }},
      {"device", "press-button", [](Value d) { return driver_of(d) && d != "simulated"; }},
      {"device", "tool-weight", [](Value d) { return driver_of(d) && !driver_of(d)->gives_force; }},
      // A check uses its own simulated hand.
      {"check", "device"},
      {"check", "firmware"},
      {"check", "tool-weight"},
      {"check", "emergency-button"},
      {"check", "deadman-button"},
      {"check", "clutch-button"}};
  return rivals;
}

/// Rules for the place and method of the bound, and for options that depend on them.
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
                   // Some methods do not allow these limits after the bound.
                   {"slew", "mode", limits, admits_limits},
                   {"ramp-up", "mode", limits, admits_limits},
                   {"velocity-limit", "mode", limits, admits_limits}};
  return rivals;
}

/// Rules for roles: a hand leads a robot, an observer only watches.
Rivals of_roles() {
  Rivals rivals = {{"lead", "role"},
                   {"lead", "view"},
                   {"lead", "bounding", {}, is_not("server")},
                   {"lead", "local-model", {}, says_yes},
                   {"role", "view", is_not("observer")}};
  // These options need a hand that leads a robot.
  for (const char* option : {"lead", "robot", "trust-robot", "robot-button"}) {
    rivals.push_back({"role", option, is("observer")});
    rivals.push_back({"local-model", option, says_no});
    rivals.push_back({"bounding", option, is("server")});
    rivals.push_back({"check", option});
  }
  return rivals;
}

/// Rules for file limits, which only MCAP recordings support.
Rivals of_recordings() {
  const auto one_file = [](Value file) { return !is_mcap(std::string(file)); };
  Rivals rivals = {{"record", "record-max-mib", one_file},
                   {"record", "record-max-seconds", one_file}};
  return rivals;
}

}  // namespace

Rivals client_rivals() {
  Rivals all = credential_rivals();
  for (const Rivals& some : {of_devices(), of_bounds(), of_roles(), of_recordings()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace feltwire
