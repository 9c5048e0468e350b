#include "client/run/rehearsal.hpp"

#include <sched.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <mutex>
#include <random>
#include <stop_token>

#include "client/hands/simulated_device.hpp"
#include "core/base/text.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {
namespace {

constexpr double kCalm = 10e-6;  // [m] limit of the swing in a calm press (docs/lab/frontier.md)
constexpr double kWhole = 0.9;   // least ratio of rendered to true stiffness that counts as whole
// [N/m] Stiffness of a wall if the scene's stiffness is unknown.
constexpr double kUsualWall = 1000.0;
constexpr double kAssumedMass = 0.1;  // [kg] mass of a device whose mass is unknown
// Ratio of the handle's mass to the device's, and of the transmission's damping to the critical
// one.
constexpr double kHandleShare = 1.0 / 3.0, kTransmissionDamping = 0.05;
constexpr double kMostForce = 3.0;  // [N] largest force of a press
constexpr double kAnyTime = 1.0;    // [s] clock time at the start of a press
constexpr double kLate = 0.1;       // largest delay of a tick, in servo periods
constexpr int kBetweenLooks = 100;  // number of ticks between two stop checks
constexpr int kPause = 4;           // ratio of a pause to the run time of the calculation before it
// [s] Approach, end, and evaluated time before the end of a press.
constexpr double kLeadIn = 1.0, kEnd = 5.5, kLooked = 0.5;
// [N/m] Stiffness of each tested wall.
constexpr std::array kWalls = {250.0, 500.0, 1e3, 2e3, 3.5e3, 5e3, 10e3, 20e3, 40e3};
constexpr std::array kHands = {Hand{.mass = 0.02, .damping = 0.5, .stiffness = 50.0},
                               Hand{.mass = 0.1, .damping = 5.0, .stiffness = 300.0}};

/// Mean position and force of the handle, and its swing: the RMS distance from a fitted straight
/// line. The line removes drift, which is no oscillation.
class HandleAtRest {
 public:
  void add(double t, double y, double at_encoder, double force) {
    at_encoder_ += at_encoder;
    count_ += 1.0, t_ += t, y_ += y, tt_ += t * t, ty_ += t * y, yy_ += y * y, force_ += force;
  }
  double mean() const { return y_ / count_; }
  double mean_at_encoder() const { return at_encoder_ / count_; }
  double force() const { return force_ / count_; }
  double swing() const {
    const double tt = tt_ - t_ * t_ / count_, ty = ty_ - t_ * y_ / count_,
                 yy = yy_ - y_ * y_ / count_;
    return std::sqrt(std::max(0.0, yy - (tt > 0.0 ? ty * ty / tt : 0.0)) / count_);
  }

 private:
  double count_ = 0.0, t_ = 0.0, y_ = 0.0, tt_ = 0.0, ty_ = 0.0, yy_ = 0.0, force_ = 0.0;
  double at_encoder_ = 0.0;
};

/// Returns the reply of a wall below y = 0. The wall is normal to y, because every device has a
/// force along y.
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
  options.plant.transmission = assumed_plant_transmission(spec);
  options.plant.encoder.side = spec.transmission.encoder_side;
  options.task.depth = press_force(spec) * (1.0 / hand.stiffness + 1.0 / wall +
                                            1.0 / options.plant.transmission.stiffness);
  options.task.lead_in = kLeadIn;
  Plant::Amplifier& amplifier = options.plant.amplifier;
  (spec.actuation.kind == LagKind::filter ? amplifier.lag : amplifier.delay) = spec.actuation.lag;
  amplifier.delay += spec.actuation.late_ticks * period;
  return SimulatedDevice(options);
}

/// Simulates a press against a wall. Returns nothing if `goes_on` stopped it.
std::optional<FirstPress> press(const DeviceSpec& spec, const SessionParameters& parameters,
                                const ServoOptions& options, double wall, const Hand& hand,
                                const std::function<bool()>& goes_on) {
  SimulatedDevice device = pressed(spec, parameters.servo_period, wall, hand);
  Servo servo(spec, parameters, options);
  std::minstd_rand random;  // each press uses the same numbers
  std::uniform_real_distribution<double> late(0.0, kLate * parameters.servo_period);
  const auto ticks = static_cast<std::int64_t>(kEnd / parameters.servo_period);
  HandleAtRest handle;
  const bool at_motor = spec.transmission.encoder_side == EncoderSide::motor;
  for (std::int64_t n = 0; n < ticks; ++n) {
    if (n % kBetweenLooks == 0 && goes_on && !goes_on()) return std::nullopt;
    const double time = static_cast<double>(n) * parameters.servo_period;
    const Nanoseconds now = from_seconds(kAnyTime + time + late(random));
    const Sample* sample = servo.tick(device, now);
    if (sample == nullptr) continue;
    servo.sent();
    servo.take(wall_reply(*sample, wall), now);
    if (time > kEnd - kLooked)
      handle.add(time, device.true_position().y(),
                 at_motor ? device.motor_position().y() : device.true_position().y(),
                 servo.held().force().y());
  }
  const auto share = [&](double depth) {
    return depth > 0.0 ? std::clamp(handle.force() / depth / wall, 0.0, 1.0) : 0.0;
  };
  return FirstPress{.wall = wall,
                    .share = share(-handle.mean()),
                    .share_at_encoder = share(-handle.mean_at_encoder()),
                    .swing = handle.swing()};
}

/// A device and a servo as a rehearsal needs them.
struct Prepared {
  DeviceSpec spec;
  ServoOptions options;
};

/// Empty where the law is not known here.
std::optional<Prepared> prepared(const DeviceSpec& told, const SessionParameters& parameters,
                                 const ServoOptions& told_options) {
  const bool known = parameters.side == BoundingSide::client && parameters.local_model;
  if (!known || told_options.leads || told_options.observes) return std::nullopt;
  Prepared all{told, told_options};
  if (!(all.spec.apparent_mass > 0.0)) all.spec.apparent_mass = kAssumedMass;
  all.options.owed = 0.0;
  return all;
}

/// Presses with each hand. Returns nothing if `goes_on` stopped it.
std::vector<FirstPress> presses(const Prepared& all, const SessionParameters& parameters,
                                double wall, const std::function<bool()>& goes_on) {
  std::vector<FirstPress> felt;
  for (const Hand& hand : kHands) {
    const auto one = press(all.spec, parameters, all.options, wall, hand, goes_on);
    if (!one) return {};
    felt.push_back(*one);
  }
  return felt;
}

std::optional<FirstPress> worst(const Prepared& all, const SessionParameters& parameters,
                                double wall, const std::function<bool()>& goes_on) {
  const std::vector<FirstPress> felt = presses(all, parameters, wall, goes_on);
  if (felt.empty()) return std::nullopt;
  FirstPress found = felt.front();
  for (const FirstPress& one : felt) {
    found.share = std::min(found.share, one.share);
    found.share_at_encoder = std::min(found.share_at_encoder, one.share_at_encoder);
    found.swing = std::max(found.swing, one.swing);
  }
  return found;
}

/// Inserts pauses into a long computation. operator() makes a pause, and returns false after a stop
/// request.
class Pieces {
 public:
  explicit Pieces(const std::stop_token& stop) : stop_(stop) {}
  bool operator()() {
    std::unique_lock lock(mutex_);
    never_.wait_for(lock, stop_, kPause * (Clock::now() - begun_), [] { return false; });
    begun_ = Clock::now();
    return !stop_.stop_requested();
  }

 private:
  using Clock = std::chrono::steady_clock;
  const std::stop_token& stop_;
  Clock::time_point begun_ = Clock::now();
  std::mutex mutex_;
  std::condition_variable_any never_;  // never notified; only a stop ends a pause early
};

}  // namespace

bool FirstPress::calm() const noexcept { return swing < kCalm; }

double press_force(const DeviceSpec& spec) {
  return std::min(kMostForce, spec.continuous_force > 0.0 ? spec.continuous_force : spec.max_force);
}

Plant::Transmission assumed_plant_transmission(const DeviceSpec& spec) {
  if (!(spec.transmission.stiffness > 0.0)) return {};
  const double handle = kHandleShare * spec.apparent_mass;
  const double reduced = handle * (1.0 - kHandleShare);
  return {.stiffness = spec.transmission.stiffness,
          .damping = 2.0 * kTransmissionDamping * std::sqrt(spec.transmission.stiffness * reduced),
          .handle_mass = handle};
}

std::vector<FirstPress> first_presses(const DeviceSpec& spec, const SessionParameters& parameters,
                                      const ServoOptions& options, double stiffness,
                                      const std::function<bool()>& goes_on) {
  const std::optional<Prepared> all = prepared(spec, parameters, options);
  return all ? presses(*all, parameters, stiffness, goes_on) : std::vector<FirstPress>{};
}

std::optional<Rehearsal> rehearse(const DeviceSpec& told, const SessionParameters& parameters,
                                  const ServoOptions& told_options, double scene_stiffness,
                                  const std::function<bool()>& goes_on) {
  const std::optional<Prepared> all = prepared(told, parameters, told_options);
  if (!all) return std::nullopt;
  const DeviceSpec& spec = all->spec;
  Rehearsal found;
  found.force = press_force(spec);
  found.transmission = spec.transmission.stiffness;
  found.mass_known = spec.least_mass > 0.0;
  const double usual = scene_stiffness > 0.0 ? scene_stiffness : kUsualWall;
  const std::optional<FirstPress> scene = worst(*all, parameters, usual, goes_on);
  if (!scene) return std::nullopt;
  found.scene = *scene;
  bool all_whole = true;
  for (const double wall : kWalls) {
    const std::optional<FirstPress> felt = worst(*all, parameters, wall, goes_on);
    if (!felt) return std::nullopt;
    found.swings = !felt->calm();
    if (found.swings) break;
    found.calm = *felt;
    all_whole = all_whole && felt->share >= kWhole;
    if (all_whole) found.whole = *felt;
    if (felt->stiffness() > found.most.stiffness()) found.most = *felt;
  }
  return found;
}

std::string rehearsal_text(const Rehearsal& rehearsal) {
  std::string text;
  append(text, "a first press with %.2g N feels %.2f of a wall of %.0f N/m", rehearsal.force,
         rehearsal.scene.share, rehearsal.scene.wall);
  if (rehearsal.transmission > 0.0)
    append(text, " behind a transmission of %.0f N/m (%.2f at the encoder)", rehearsal.transmission,
           rehearsal.scene.share_at_encoder);
  if (!rehearsal.scene.calm()) text += ", and a hand swings on it";
  if (rehearsal.whole.wall > 0.0)
    append(text, "; walls up to %.0f N/m are felt to %.2f or more", rehearsal.whole.wall, kWhole);
  if (rehearsal.most.wall > 0.0)
    append(text, "; the most that is felt is %.0f N/m", rehearsal.most.stiffness());
  if (rehearsal.swings && rehearsal.calm.wall > 0.0)
    append(text, "; on stiffer walls than %.0f N/m a hand swings", rehearsal.calm.wall);
  if (rehearsal.swings && !(rehearsal.calm.wall > 0.0)) text += "; on each wall a hand swings";
  if (!rehearsal.mass_known && rehearsal.scene.share < kWhole)
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
            const sched_param none{};
            ::sched_setscheduler(0, SCHED_IDLE, &none);
            Pieces pieces(stop);
            found_ = rehearse(spec, parameters, options, scene_stiffness, std::ref(pieces));
            if (found_)
              std::fprintf(stderr, "feltwire-client: note: %s\n", rehearsal_text(*found_).c_str());
          } catch (const std::exception& error) {
            std::fprintf(stderr, "feltwire-client: note: a first press cannot be foretold: %s\n",
                         visible(error.what()).c_str());
          }
        });
  } catch (const std::exception&) {  // the run continues without the rehearsal
  }
}

std::optional<Rehearsal> RehearsalThread::finish() noexcept {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  return found_;
}

}  // namespace feltwire
