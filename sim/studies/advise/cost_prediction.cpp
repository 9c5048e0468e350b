#include "sim/studies/advise/cost_prediction.hpp"

#include <algorithm>
#include <cmath>

#include "client/run/rehearsal.hpp"
#include "sim/measure/network_run.hpp"

namespace feltwire::advise {
namespace {

// docs/lab/benchmarks.md, "The server under load": an echo takes this of the CPU for a datagram and
// its answer at saturation.
constexpr double kKernel = 3.2e-6;  // [s]
constexpr double kUsable = 0.9;     // share of a core that hands may fill
// docs/lab/advise.md, "Memory": resident memory of the programs with one plane.
constexpr double kServerBase = 15e6, kClientBase = 37e6;  // [bytes]
// docs/lab/trade.md, "Scenes".
constexpr double kSession = 10.2e3, kSessionObject = 110.0;  // [bytes]
constexpr double kFirstBody = 0.11e6, kBody = 0.13e6;        // [bytes]
constexpr double kReferenceTime = 1.0;                       // [s] of a reference session
constexpr int kTimes = 3;  // of each reference session; the fastest counts

struct Reference {
  double server = 1e9, client = 1e9;  // [s] of computing
  double ticks = 0.0, up = 0.0, down = 0.0;
};

Scene plane() {
  Object object{.name = "plane", .shape = Plane{}, .pose = {}, .material = {}};
  return Scene("plane", {object});
}

Reference reference(const DeviceSpec& device, Setting setting, const char* profile) {
  setting.profile = profile;
  NetworkRunOptions options;
  options.parameters = setting.parameters();
  options.hand.spec = device;
  if (!(options.hand.spec.apparent_mass > 0.0)) options.hand.spec.apparent_mass = 0.1;
  options.hand.task.lead_in = 0.3;
  options.duration = kReferenceTime;
  options.timed = true;
  Reference best;
  for (int n = 0; n < kTimes; ++n) {
    const NetworkRunResult run = run_network(plane(), options);
    best.server = std::min(best.server, seconds(run.server_time));
    best.client = std::min(best.client, seconds(run.client_time));
    best.ticks = static_cast<double>(run.samples.size());
    best.up = static_cast<double>(run.up.datagrams);
    best.down = static_cast<double>(run.down.datagrams);
  }
  return best;
}

}  // namespace

MachineSpeed measure_machine(const DeviceSpec& device, const Setting& setting) {
  const Reference many = reference(device, setting, "lan"), few = reference(device, setting, "wan");
  MachineSpeed speed;
  // server: up received + down replied, in both sessions
  const double determinant = many.up * few.down - few.up * many.down;
  if (std::abs(determinant) > 1.0) {
    speed.received = (many.server * few.down - few.server * many.down) / determinant;
    speed.replied = (many.up * few.server - few.up * many.server) / determinant;
  }
  if (!(speed.received > 0.0) || !(speed.replied > 0.0))
    speed.received = speed.replied = many.server / (many.up + many.down);
  const double more = many.up + many.down - few.up - few.down;
  speed.datagram = std::max(0.0, (many.client - few.client) / more);
  speed.tick =
      std::max(0.0, few.client - speed.datagram * (few.up + few.down)) / std::max(1.0, few.ticks);
  const Scene scene = plane();
  const PlaceCost place = cost_at(scene, Place{}, true);
  speed.touch = place.touch + place.model;
  return speed;
}

double tick_time(std::size_t bodies) {
  if (bodies == 0) return 0.0;
  // 4.4, 49 and 630 us of 1, 10 and 100 bodies: between them the logarithms go in straight lines.
  constexpr double kOne = 4.4e-6, kTen = 49e-6, kHundred = 630e-6;
  const double decades = std::log10(static_cast<double>(bodies));
  if (decades <= 1.0) return kOne * std::pow(kTen / kOne, decades);
  return kTen * std::pow(kHundred / kTen, decades - 1.0);
}

Cost cost_of(const MachineSpeed& machine, const SceneFacts& scene, const PlaceCost& place,
             const Setting& setting, const Traffic& traffic, double arrives, int hands) {
  Cost cost;
  const double received = arrives / traffic.up.interval, replied = 1.0 / traffic.down.interval;
  const double here = place.touch + place.model;
  const double each = std::max(0.5 * machine.received, machine.received + here - machine.touch);
  cost.server = received * each + replied * machine.replied;
  cost.kernel = received * kKernel;
  const double own_contact = std::max(0.0, place.touch - machine.touch);
  cost.client = setting.rate * (machine.tick + own_contact) +
                machine.datagram * (1.0 / traffic.up.interval + replied);
  if (scene.tick > 0.0) cost.tick = tick_time(scene.moving) / scene.tick;
  cost.hands_a_core = std::max(0.0, kUsable - cost.tick) / (cost.server + cost.kernel);
  cost.session_memory = kSession + kSessionObject * static_cast<double>(scene.objects);
  double bodies = 0.0;
  if (scene.moving > 0) bodies = kFirstBody + kBody * static_cast<double>(scene.moving - 1);
  cost.server_memory = kServerBase + static_cast<double>(scene.geometry_bytes) + bodies +
                       hands * cost.session_memory;
  cost.client_memory = kClientBase + static_cast<double>(scene.geometry_bytes);
  return cost;
}

}  // namespace feltwire::advise
