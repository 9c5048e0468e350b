#include "sim/measure/network_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <variant>

#include "client/transport/datagram_session.hpp"
#include "core/local_model_extraction/prefetched_tool_data.hpp"
#include "core/prefetched_geometry/make_prefetched_tool.hpp"
#include "core/prefetched_geometry/mesh_surfaces.hpp"
#include "core/tool/body_tool.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kOnTheWay = 8192;  // largest number of datagrams in transit, per direction
constexpr std::uint64_t kSessionId = 0x51de5;

/// Returns fixed keys. They need not be secret, because client and server are in one process.
SessionKeys keys() { return {.suite = preferred_suite(), .up = {1}, .down = {2}}; }
constexpr std::size_t kSessions = 1;

/// A device and its true movement, which has no encoder errors.
class TruePort {
 public:
  explicit TruePort(const NetworkRunOptions& options)
      : device_(make(options)),
        period_(options.parameters.servo_period),
        friction_(options.hand.spec.coulomb_friction),
        rotational_friction_(options.hand.spec.rotation.friction) {}

  Device& device() {
    return std::visit([](auto& device) -> Device& { return device; }, device_);
  }
  /// Updates the true movement after a tick. For a device without a simulation, the true position
  /// is `measured` [m].
  void look(const Vec3& measured) {
    const auto* hand = std::get_if<SimulatedDevice>(&device_);
    const Vec3 position = hand != nullptr ? hand->true_position() : measured;
    const Vec3 motor = hand != nullptr ? hand->motor_position() : measured;
    moved_ = known_ ? Vec3(motor - motor_) : Vec3::Zero();
    motor_ = motor;
    velocity_ = hand != nullptr ? hand->true_velocity() : Vec3(moved_ / period_);
    position_ = position;
    const Quaternion orientation =
        hand != nullptr ? hand->true_orientation() : Quaternion::Identity();
    turned_ = known_ ? rotation_between(orientation_, orientation) : Vec3::Zero();
    orientation_ = orientation;
    known_ = true;
  }

  const Vec3& position() const { return position_; }
  const Vec3& velocity() const { return velocity_; }
  const Quaternion& orientation() const { return orientation_; }
  const Vec3& moved() const { return moved_; }  // [m] movement of the motor in the last tick
  const Vec3& turned_since() const { return turned_; }  // [rad] rotation in the last tick
  TrueEnergy energy() const {
    const auto* hand = std::get_if<SimulatedDevice>(&device_);
    return hand != nullptr ? hand->true_energy() : TrueEnergy{};
  }
  /// Returns the least energy [J] that Coulomb friction dissipated in the last tick, as the sum
  /// over the axes.
  double friction_work() const {
    return friction_ * moved_.lpNorm<1>() + rotational_friction_ * turned_.lpNorm<1>();
  }

 private:
  using Either = std::variant<SimulatedDevice, ReplayDevice, AdversarialHand>;
  static Either make(const NetworkRunOptions& options) {
    if (options.taking)
      return Either(std::in_place_type<AdversarialHand>, *options.taking, options.hand.spec);
    if (!options.recording) return Either(std::in_place_type<SimulatedDevice>, options.hand);
    Recording positions = *options.recording;
    positions.rotation = false;
    return Either(std::in_place_type<ReplayDevice>, std::move(positions), options.hand.spec);
  }

  Either device_;
  double period_, friction_, rotational_friction_;
  bool known_ = false;
  Vec3 position_ = Vec3::Zero(), motor_ = Vec3::Zero(), velocity_ = Vec3::Zero(),
       moved_ = Vec3::Zero();
  Quaternion orientation_ = Quaternion::Identity();
  Vec3 turned_ = Vec3::Zero();
};

void check(const NetworkRunOptions& options) {
  if (!(options.duration > options.parameters.servo_period) || !std::isfinite(options.duration))
    throw std::invalid_argument("the duration must be finite and longer than one servo period [s]");
  if (!(options.silence_timeout > 0.0) || !std::isfinite(options.silence_timeout))
    throw std::invalid_argument("the silence timeout must be finite and above zero [s]");
  if (options.recording && options.taking)
    throw std::invalid_argument("a recording and a taking hand cannot both move the device");
  if (options.taking && !(options.hand.spec.damping.least() > 0.0))
    throw std::invalid_argument("a taking hand needs a device with damping above zero [N s/m]");
  if (options.recording && options.recording->poses.empty())
    throw std::invalid_argument("the recording has no poses; record something");
  validate(options.link.up);
  validate(options.link.down);
}

control::JoinAccepted join(SceneSessions& sessions, const Scene& scene, const DeviceSpec& told,
                           const SessionParameters& parameters) {
  const control::Message answer = sessions.answer(
      control::JoinRequest{"lab", scene.name(), told, parameters}, kSessionId, keys(), {});
  if (const auto* refused = std::get_if<control::Refused>(&answer))
    throw std::invalid_argument(refused->reason);
  return std::get<control::JoinAccepted>(answer);
}

PortEnergy port_of(const NetworkRunOptions& options) {
  return {options.hand.spec.damping, options.hand.spec.rotational_damping,
          options.parameters.servo_period};
}

/// Adds the lifetime of this object to `sum`, unless `sum` is null.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;
  explicit Stopwatch(Nanoseconds* sum)
      : sum_(sum), begin_(sum != nullptr ? Clock::now() : Clock::time_point{}) {}
  ~Stopwatch() {
    if (sum_ != nullptr) *sum_ += Clock::now() - begin_;
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  Nanoseconds* sum_;
  Clock::time_point begin_;
};

ServoOptions with_stiffness(ServoOptions options, const control::JoinAccepted& accepted) {
  options.scene_stiffness = accepted.stiffness;
  return options;
}

/// Sets up the server as if the client had fetched the scene. Returns the fetched data for the
/// client, or null if the scene has no such data.
std::unique_ptr<const FetchedScene> share(const Scene& scene, SceneSessions& sessions) {
  const ToolView& view = scene;
  const BodyTool* body = view.tool().body.get();
  if (body != nullptr && !can_travel(*body)) return nullptr;
  FetchedScene fetched;
  std::vector<SurfaceData> surfaces;
  std::vector<SolidData> solids;
  for (std::size_t i = 0; i < view.still() && fetched.objects.size() < control::kMaxSurfaces; ++i) {
    if (!can_travel(view, i)) continue;
    const auto index = static_cast<std::uint16_t>(i);
    fetched.objects.push_back(index);
    if (body != nullptr)
      solids.push_back(solid_data_with_triangles(view, index));
    else
      surfaces.push_back(surface_data_with_triangles(view.objects()[i], index, view.tool().radius));
  }
  if (body == nullptr && surfaces.empty()) return nullptr;
  const std::uint32_t version =
      prefetched_version(view, sessions.scene_version(), sessions.live_changes());
  sessions.answer(control::TakeSurfaces{kSessionId, version, fetched.objects}, 0, {}, {});
  if (body != nullptr)
    fetched.body = make_prefetched_tool(version, body_data(*body, sessions.gravity()), solids);
  else
    fetched.surfaces = mesh_surfaces(version, surfaces);
  return std::make_unique<const FetchedScene>(std::move(fetched));
}

class NetworkRun {
 public:
  NetworkRun(const Scene& scene, const NetworkRunOptions& options)
      : scene_(scene),
        told_(options.told.value_or(options.hand.spec)),
        sessions_(scene, from_seconds(options.silence_timeout), kSessions),
        accepted_(join(sessions_, scene, told_, options.parameters)),
        servo_(told_, accepted_.parameters, with_stiffness(options.servo, accepted_)),
        datagrams_(accepted_.session, keys(), accepted_.parameters, told_.rotation_sensed > 0,
                   {told_.position_resolution, accepted_.stiffness}),
        link_(options.link, 0, kOnTheWay),
        port_(options),
        ideal_(scene.memory()),
        ideal_contacts_(sessions_.world() != nullptr ? sessions_.world()->contact_state()
                                                     : BodyContactState{}),
        timed_(options.timed),
        result_{.measured_port = port_of(options),
                .true_port = port_of(options),
                .observed_port = servo_.port()} {
    if (!accepted_.parameters.local_model || !options.whole_scene) return;
    fetched_ = share(scene, sessions_);
    servo_.use(fetched_.get());
  }

  NetworkRunResult run(double duration) {
    const double period = accepted_.parameters.servo_period;
    const auto count = static_cast<std::size_t>(std::floor(duration / period + 0.5)) + 1;
    result_.samples.reserve(count);
    for (std::size_t n = 0; n < count; ++n) {
      const Nanoseconds now = from_seconds(static_cast<double>(n) * period);
      deliver(now);
      tick(now, static_cast<double>(n) * period, period);
    }
    result_.servo = servo_.statistics();
    result_.true_energy = port_.energy();
    result_.observed_port = servo_.port();
    result_.clock = servo_.server_clock();
    result_.client_drops = datagrams_.dropped();
    result_.server = sessions_.counters();
    result_.up_link = link_.up.statistics();
    result_.down_link = link_.down.statistics();
    return std::move(result_);
  }

 private:
  /// Delivers the datagrams that are due by `until`, each at its due time.
  void deliver(Nanoseconds until) {
    while (const auto due = link_.next_due()) {
      if (*due > until) break;
      if (const auto datagram = link_.up.leave(*due))
        send(link_.down, result_.down, receive(*datagram, *due), *due);
      else if (const auto answer = link_.down.leave(*due))
        take(*answer, *due);
    }
    sessions_.tick(until);
    for (const auto& goodbye : sessions_.expire(until))
      send(link_.down, result_.down, goodbye.datagram, until);
  }

  Bytes receive(Bytes datagram, Nanoseconds now) {
    const Stopwatch stopwatch(timed_ ? &result_.server_time : nullptr);
    return sessions_.receive(datagram, Peer{}, now, answer_);
  }

  static void send(OneWayLink& link, DatagramCount& count, Bytes datagram, Nanoseconds now) {
    if (datagram.empty()) return;
    ++count.datagrams;
    count.bytes += datagram.size() + kHeadersOnTheWire;
    link.enter(datagram, now);
  }

  void take(Bytes datagram, Nanoseconds now) {
    const Stopwatch stopwatch(timed_ ? &result_.client_time : nullptr);
    Reply reply;
    GoodbyeReason reason{};
    switch (datagrams_.take(datagram, reply, reason)) {
      case DatagramSession::Arrival::reply:
        servo_.take(reply, now);
        break;
      case DatagramSession::Arrival::goodbye:
        result_.goodbye = true;
        break;
      case DatagramSession::Arrival::dropped:
        break;
    }
  }

  void tick(Nanoseconds now, double time, double period) {
    const Command acted = servo_.held();
    const Pose before = servo_.sample().pose;
    const Sample* sample = servo_tick(now);
    if (sample == nullptr) return;
    port_.look(sample->pose.position);
    account(acted, result_.samples.empty() ? sample->pose : before, sample->pose, period);
    result_.samples.push_back({.time = time,
                               .position = port_.position(),
                               .velocity = port_.velocity(),
                               .acted = acted.force(),
                               .orientation = port_.orientation(),
                               .held = servo_.held(),
                               .ideal = ideal(period),
                               .command = servo_.command(),
                               .command_age = servo_.command_age(),
                               .sample_index = servo_.newest_reply().sample_index});
    if (!result_.goodbye) send(link_.up, result_.up, pack(*sample), now);
  }

  const Sample* servo_tick(Nanoseconds now) {
    const DeviceReading reading = port_.device().read(now);
    Command force;
    {
      const Stopwatch stopwatch(timed_ ? &result_.client_time : nullptr);
      force = servo_.render(reading, now);
    }
    const Command held = port_.device().write(force);
    const Stopwatch stopwatch(timed_ ? &result_.client_time : nullptr);
    return servo_.hold(held);
  }

  Bytes pack(const Sample& sample) {
    const Stopwatch stopwatch(timed_ ? &result_.client_time : nullptr);
    const Bytes datagram = datagrams_.pack(sample);
    if (!datagram.empty()) servo_.sent();
    return datagram;
  }

  Command ideal(double period) {
    const Tool tool{port_.position(), port_.velocity()};
    const World* world = sessions_.world();
    if (scene_.tool().body != nullptr) {
      const Pose pose{port_.position(), port_.orientation()};
      return world != nullptr
                 ? world->touch(pose, tool.velocity, period, ideal_body_, ideal_contacts_)
                 : scene_.touch(pose, tool.velocity, period, ideal_body_);
    }
    return world != nullptr ? world->touch(tool, ideal_, ideal_contacts_)
                            : scene_.touch(tool, ideal_);
  }

  void account(const Command& acted, const Pose& before, const Pose& now, double period) {
    result_.measured_port.step(acted, now.position - before.position,
                               rotation_between(before.orientation, now.orientation), period);
    PortEnergy& port = result_.true_port;
    port.step(acted, port_.moved(), port_.turned_since(), period);
    friction_work_ += port_.friction_work();
    result_.least_device_margin = std::min(
        result_.least_device_margin, port.burned() + friction_work_ - port.delivered().total());
  }

  const Scene& scene_;
  DeviceSpec told_;
  SceneSessions sessions_;
  control::JoinAccepted accepted_;
  std::unique_ptr<const FetchedScene> fetched_;
  Servo servo_;
  DatagramSession datagrams_;
  TwoWayLink link_;
  TruePort port_;
  DatagramBuffer answer_;  // buffer for a reply of the server
  TouchMemory ideal_;
  BodyMemory ideal_body_;
  BodyContactState ideal_contacts_;
  bool timed_;
  double friction_work_ = 0.0;  // [J] dissipated by Coulomb friction since the start
  NetworkRunResult result_;
};

}  // namespace

NetworkRunResult run_network(const Scene& scene, const NetworkRunOptions& options) {
  check(options);
  return NetworkRun(scene, options).run(options.duration);
}

}  // namespace feltwire
