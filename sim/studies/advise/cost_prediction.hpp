#pragma once
// The computing time and the memory of a session.

#include "core/device/device_spec.hpp"
#include "sim/studies/advise/advice_setting.hpp"
#include "sim/studies/advise/scene_facts.hpp"
#include "sim/studies/advise/traffic_prediction.hpp"

namespace feltwire::advise {

/// The speed of this machine: computing times [s] of a session on one plane, without system calls.
struct MachineSpeed {
  double received = 0.0;  // of the server for a datagram with a new sample
  double replied = 0.0;   // of the server for a reply
  double tick = 0.0;      // of the client for a servo tick
  double datagram = 0.0;  // of the client for a datagram, sent or received
  double touch = 0.0;     // of one contact query, with the local model
};
/// Measures with two short sessions on a plane, in this thread: half a second of computing time.
/// The device and the law are those of the question, because a lag and the account cost time too.
MachineSpeed measure_machine(const DeviceSpec& device, const Setting& setting);

struct Cost {
  // [s] for a second of session, of one hand
  double server = 0.0;  // computing, without system calls
  double kernel = 0.0;  // system calls of the server, where the core is full of hands
  double client = 0.0;  // computing, without system calls
  double tick = 0.0;    // of the moving bodies of the scene, once for all hands
  double hands_a_core = 0.0;
  // [bytes] resident
  double server_memory = 0.0, session_memory = 0.0, client_memory = 0.0;
};

/// `traffic` of one hand; `place`: where it touches. `hands` share the scene.
Cost cost_of(const MachineSpeed& machine, const SceneFacts& scene, const PlaceCost& place,
             const Setting& setting, const Traffic& traffic, double arrives, int hands);

/// [s] A tick of so many moving bodies, by the table of docs/lab/benchmarks.md: at rest on a table.
double tick_time(std::size_t bodies);

}  // namespace feltwire::advise
