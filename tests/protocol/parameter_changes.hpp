#pragma once
// A change of every field of SessionParameters, and whether protocol/session/grant.hpp permits it.
// Shared by the tests of these rules and by the tests of a server that lies.

#include <string>
#include <vector>

#include "protocol/session/grant.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire::test {

/// Two valid sets of parameters that differ in one field: the asked and the granted ones.
struct ParameterChange {
  std::string field;
  SessionParameters asked, granted;
  bool permitted = false;
};

/// Includes changes at both limits. All sets are valid, so only the rule can refuse them.
inline std::vector<ParameterChange> parameter_changes() {
  std::vector<ParameterChange> all;
  SessionParameters asked;
  const auto change = [&](const char* field, bool permitted, auto&& spoil) {
    SessionParameters granted = asked;
    spoil(granted);
    all.push_back({field, asked, granted, permitted});
  };
  using P = SessionParameters;
  change("mode", false, [](P& p) { p.mode = "none"; });
  change("mode", false, [](P& p) { p.mode = "energy_tank"; });
  change("projection", false, [](P& p) { p.projection = Projection::joint; });
  change("storage", false, [](P& p) { p.storage = Storage::elastic; });
  change("servo_period", false, [](P& p) { p.servo_period = 1e-4; });
  change("servo_period", false, [](P& p) { p.servo_period = 2e-3; });
  change("operator_damping", false, [](P& p) { p.operator_damping = 100.0; });
  change("operator_damping", false, [](P& p) { p.operator_damping = 5e-324; });
  change("velocity_cutoff", false, [](P& p) { p.velocity_cutoff = 50.0; });
  change("c1", false, [](P& p) { p.c1 = 1e9; });
  change("c2", false, [](P& p) { p.c2 = 0.0; });
  change("reference", false, [](P& p) { p.reference = PassivityReference::following; });
  change("coupling_stiffness", false, [](P& p) { p.coupling_stiffness = 1e9; });
  change("coupling_damping", false, [](P& p) { p.coupling_damping = 0.0; });
  change("tool_mass", false, [](P& p) { p.tool_mass = 1e-6; });

  change("side", false, [](P& p) { p.side = BoundingSide::server; });
  change("side", false, [](P& p) { p.side = BoundingSide::both; });
  asked.side = BoundingSide::both;
  change("side", false, [](P& p) { p.side = BoundingSide::server; });
  change("side", false, [](P& p) { p.side = BoundingSide::client; });
  asked.side = BoundingSide::server;
  change("side", false, [](P& p) { p.side = BoundingSide::both; });
  change("side", true, [](P& p) { p.side = BoundingSide::client; });
  asked = {};

  change("redundancy", true, [](P& p) { p.redundancy = 0; });
  change("redundancy", true, [](P& p) { p.redundancy = kMaxRedundancy; });
  change("packet_interval", true, [](P& p) { p.packet_interval = 100; });
  asked.packet_interval = 10;
  change("packet_interval", true, [](P& p) { p.packet_interval = 1; });
  change("batch", true, [](P& p) { p.batch = 6; });
  asked = {};
  change("position_deadband", true, [](P& p) { p.position_deadband = kMaxDeadband; });
  change("force_deadband", true, [](P& p) { p.force_deadband = kMaxDeadband; });
  change("predictor", true, [](P& p) { p.predictor = Predictor::linear; });
  change("local_model", true, [](P& p) { p.local_model = true; });
  asked.local_model = true;
  change("local_model", true, [](P& p) { p.local_model = false; });
  asked = {};

  change("hold_time", false, [](P& p) { p.hold_time = 0.1000001; });
  change("hold_time", false, [](P& p) { p.hold_time = 0.8; });
  change("hold_time", false, [](P& p) { p.hold_time = 1.0; });
  change("hold_time", false, [](P& p) { p.hold_time = 0.09; });
  asked.hold_time = 1.0;
  change("hold_time", true, [](P& p) { p.hold_time = 0.9; });
  change("hold_time", true, [](P& p) { p.hold_time = 0.1; });
  change("hold_time", false, [](P& p) { p.hold_time = 0.09; });
  asked.hold_time = 0.05;
  change("hold_time", false, [](P& p) { p.hold_time = 0.1; });
  change("hold_time", false, [](P& p) { p.hold_time = 0.04; });
  asked = {};
  change("keep_alive", true, [](P& p) { p.keep_alive = 0.05; });
  change("keep_alive", true, [](P& p) { p.keep_alive = 0.0; });
  change("keep_alive", false, [](P& p) { p.keep_alive = 0.051; });
  change("keep_alive", false, [](P& p) { p.keep_alive = 1.0; });
  asked.keep_alive = 0.2;
  change("keep_alive", true, [](P& p) { p.keep_alive = 0.19; });
  change("keep_alive", false, [](P& p) { p.keep_alive = 0.21; });
  return all;
}

}  // namespace feltwire::test
