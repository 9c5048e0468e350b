#include "client/run/rehearsal.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>

#include "client/devices/simulated_device.hpp"
#include "core/base/text.hpp"

namespace feltwire {
namespace {

constexpr int kLeastPriority = 19;                          // of a thread that is not real-time
constexpr double kCalm = 10e-6;                             // [m] as in docs/lab/frontier.md
constexpr double kWhole = 0.9;                              // share of a wall that is felt as it is
constexpr double kUsualWall = 1000.0;                       // [N/m]
constexpr double kAssumedMass = 0.1;                        // [kg]
constexpr double kMostForce = 3.0;                          // [N]
constexpr double kLeadIn = 1.0, kEnd = 5.5, kLooked = 0.5;  // [s] of a press
constexpr std::array kWalls = {250.0, 500.0, 1e3, 2e3, 3.5e3, 5e3, 10e3, 20e3, 40e3};  // [N/m]
constexpr std::array kHands = {Hand{.mass = 0.02, .damping = 0.5, .stiffness = 50.0},
                               Hand{.mass = 0.1, .damping = 5.0, .stiffness = 300.0}};

double press_force(const DeviceSpec& spec) { return std::min(kMostForce, spec.continuous_force); }

/// A wall below y = 0: each device has a force along y.
Reply wall_reply(const Sample& sample, double stiffness) {
  Reply reply;
  reply.sample_index = sample.index;
  reply.client_time = sample.client_time;
  reply.command.elastic.y() = stiffness * std::max(0.0, -sample.pose.position.y());
  reply.modelled = true;
  reply.model.center = sample.pose.position;
  reply.model.reach = 1.0;
  reply.model.count = 1;
  SurfacePatch& wall = reply.model.patches[0];
  wall.normal = Vec3::UnitY();
  wall.radius = 1.0;
  wall.material.stiffness = stiffness;
  return reply;
}

SimulatedDevice pressed(const DeviceSpec& spec, double period, double wall, const Hand& hand) {
  SimulatedHandOptions options;
  options.spec = spec;
  options.hand = hand;
  options.task.normal = Vec3::UnitY();
  options.task.depth = press_force(spec) * (1.0 / hand.stiffness + 1.0 / wall);
  options.task.lead_in = kLeadIn;
  Plant::Amplifier& amplifier = options.plant.amplifier;
  (spec.actuation_kind == LagKind::filter ? amplifier.lag : amplifier.delay) = spec.actuation_lag;
  amplifier.delay += spec.late_ticks * period;
  return SimulatedDevice(options);
}

Felt press(const DeviceSpec& spec, const SessionParameters& parameters, const ServoOptions& options,
           double wall, const Hand& hand) {
  SimulatedDevice device = pressed(spec, parameters.servo_period, wall, hand);
  Servo servo(spec, parameters, options);
  const Nanoseconds period = from_seconds(parameters.servo_period);
  Nanoseconds now = from_seconds(1.0);  // any time
  double count = 0.0, place = 0.0, squares = 0.0, force = 0.0;
  for (double time = 0.0; time < kEnd; time += parameters.servo_period, now += period) {
    const Sample* sample = servo.tick(device, now);
    if (sample == nullptr) continue;
    servo.sent();
    servo.take(wall_reply(*sample, wall), now);
    if (time < kEnd - kLooked) continue;
    const double y = device.true_position().y();
    count += 1.0;
    place += y;
    squares += y * y;
    force += servo.held().force().y();
  }
  const double depth = -place / count;
  return {.wall = wall,
          .share = depth > 0.0 ? force / count / depth / wall : 0.0,
          .swing = std::sqrt(std::max(0.0, squares / count - depth * depth))};
}

Felt worst(const DeviceSpec& spec, const SessionParameters& parameters, const ServoOptions& options,
           double wall) {
  Felt found{.wall = wall, .share = std::numeric_limits<double>::infinity()};
  for (const Hand& hand : kHands) {
    const Felt felt = press(spec, parameters, options, wall, hand);
    found.share = std::min(found.share, felt.share);
    found.swing = std::max(found.swing, felt.swing);
  }
  return found;
}

}  // namespace

bool Felt::calm() const noexcept { return swing < kCalm; }

std::optional<Rehearsal> rehearse(const DeviceSpec& told, const SessionParameters& parameters,
                                  const ServoOptions& told_options, double scene_stiffness,
                                  const std::stop_token& stop) {
  const bool known = parameters.side == BoundingSide::client && parameters.local_model;
  if (!known || told_options.leads || told_options.observes) return std::nullopt;
  DeviceSpec spec = told;
  if (!(spec.apparent_mass > 0.0)) spec.apparent_mass = kAssumedMass;
  ServoOptions options = told_options;
  options.owed = 0.0;
  Rehearsal found;
  found.force = press_force(spec);
  found.mass_known = spec.least_mass > 0.0;
  found.scene =
      worst(spec, parameters, options, scene_stiffness > 0.0 ? scene_stiffness : kUsualWall);
  bool all_whole = true;
  for (const double wall : kWalls) {
    if (stop.stop_requested()) return std::nullopt;
    const Felt felt = worst(spec, parameters, options, wall);
    found.swings = !felt.calm();
    if (found.swings) break;
    found.calm = felt;
    all_whole = all_whole && felt.share >= kWhole;
    if (all_whole) found.whole = felt;
    if (felt.stiffness() > found.most.stiffness()) found.most = felt;
  }
  return found;
}

std::string rehearsal_text(const Rehearsal& rehearsal) {
  std::string text;
  append(text, "a first press with %.1f N feels %.2f of a wall of %.0f N/m", rehearsal.force,
         rehearsal.scene.share, rehearsal.scene.wall);
  if (!rehearsal.scene.calm()) text += ", and a hand swings on it";
  if (rehearsal.whole.wall > 0.0)
    append(text, "; walls up to %.0f N/m are felt to %.2f or more", rehearsal.whole.wall, kWhole);
  if (rehearsal.most.wall > 0.0)
    append(text, "; the most that is felt is %.0f N/m", rehearsal.most.stiffness());
  if (rehearsal.swings) append(text, "; above %.0f N/m a hand swings", rehearsal.calm.wall);
  if (!rehearsal.mass_known)
    text +=
        "; the device file has no least_mass, so a first press gets little: measure it with "
        "feltwire-client identify";
  return text;
}

RehearsalThread::RehearsalThread(const DeviceSpec& spec, const SessionParameters& parameters,
                                 const ServoOptions& options, double scene_stiffness) noexcept {
  try {
    thread_ = std::jthread(
        [this, spec, parameters, options, scene_stiffness](const std::stop_token& stop) {
          try {
            ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), kLeastPriority);
            found_ = rehearse(spec, parameters, options, scene_stiffness, stop);
            if (found_)
              std::fprintf(stderr, "feltwire-client: note: %s\n", rehearsal_text(*found_).c_str());
          } catch (const std::exception&) {  // the run does without
          }
        });
  } catch (const std::exception&) {  // the run does without
  }
}

std::optional<Rehearsal> RehearsalThread::finish() noexcept {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return found_;
}

}  // namespace feltwire
