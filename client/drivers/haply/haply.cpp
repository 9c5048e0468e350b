#include "client/drivers/haply/haply.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <utility>

#include "client/device/assumed_transmission.hpp"
#include "client/device/held_command.hpp"
#include "client/device/lock_step.hpp"
#include "client/drivers/haply/haply_messages.hpp"
#include "client/drivers/haply/service_socket.hpp"
#include "core/base/numeric.hpp"
#include "core/base/visible_text.hpp"
#include "core/device/spec_text.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace haply {
namespace {

using std::chrono::milliseconds;

constexpr std::uint16_t kUsualPort = 10001;
constexpr std::size_t kLongestMessage = 65536;
constexpr Nanoseconds kPatience = milliseconds(3000);  // longest wait for an answer at the start
constexpr int kAnswers = 50;          // largest number of old messages that forget() discards
constexpr double kFarthest = 1.0;     // [m] largest distance of a valid position
constexpr double kSmallForce = 0.02;  // [N] tolerance for equal forces
constexpr double kDigits = 1e6;       // rounding steps per newton of a command

[[noreturn]] void refuse_service(const std::string& why) {
  throw std::runtime_error("haply: " + why);
}

/// The maker's axes are x right, y away from the user and z up. Feltwire's axes are x towards the
/// user, y right and z up, with the origin in the centre of the workspace.
constexpr double kAway = -0.12, kUp = 0.15;  // [m] centre of the workspace in the maker's frame
Vec3 turned_to_ours(const Vec3& v) { return {-v.y(), v.x(), v.z()}; }
Vec3 turned_to_theirs(const Vec3& v) { return {v.y(), -v.x(), v.z()}; }
Quaternion turned_to_ours(const Quaternion& q) { return {q.w(), -q.y(), q.x(), q.z()}; }

struct Place {
  std::string id;
  std::uint16_t port = kUsualPort;
};

Place place_of(const std::string& name) {
  const std::size_t at = name.find('@');
  Place place{.id = name.substr(0, at)};
  const auto plain = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' ||
           c == '_';
  };
  bool good = place.id.size() <= kMostId && std::all_of(place.id.begin(), place.id.end(), plain);
  if (at != std::string::npos) {
    const char* end = name.data() + name.size();
    const auto read = std::from_chars(name.data() + at + 1, end, place.port);
    good = good && read.ec == std::errc() && read.ptr == end && place.port != 0;
  }
  if (!good)
    refuse_service("'" + visible(name) +
                   "' is no device of the service; write haply, haply:ID, haply:@PORT or "
                   "haply:ID@PORT, as haply:049D@10001");
  return place;
}

class HaplyDevice final : public LockStepDevice {
 public:
  HaplyDevice(const Place& place, const DeviceRequest& request)
      : LockStepDevice(sourced_spec("inverse3"), request.spec),
        socket_(place.port, kLongestMessage) {
    assume_transmission(described_, kUnknownDrive);
    notes_ = assumptions(described_);
    take_inventory(place.id);
    see_to_answers();
    notes_.emplace_back(kTickNote);
  }
  ~HaplyDevice() override { release(); }
  HaplyDevice(const HaplyDevice&) = delete;
  HaplyDevice& operator=(const HaplyDevice&) = delete;

  std::vector<std::string> notes() const { return notes_; }

 private:
  void let_go() noexcept override { socket_.post(zero_); }

  std::optional<Command> send(const Command& command) noexcept override {
    // Refuse the command after an unexpected message. Otherwise each later answer would match the
    // wrong command.
    if (owed_ == 0 && socket_.receive(Nanoseconds(0)) != ServiceSocket::ReceiveResult::none) {
      say(Vec3::Zero(), false);
      return std::nullopt;
    }
    const Vec3 rounded = (kDigits * command.force()).array().round().matrix() / kDigits;
    if (!say(turned_to_theirs(rounded), false)) return std::nullopt;
    asked_for_ = rounded;
    return held_command(command, rounded, Vec3::Zero());
  }

  bool say(const Vec3& force, bool first) noexcept {
    std::array<char, kMostCommand> text{};
    const std::size_t size = write_command(dialect_, id_, force, first, text);
    ++owed_;
    return socket_.send({text.data(), size});
  }

  /// Receives all outstanding answers. The buffer keeps the last answer.
  Answer hear(Nanoseconds latest) noexcept {
    while (owed_ > 0) {
      switch (socket_.receive(latest)) {
        case ServiceSocket::ReceiveResult::none:
          return Answer::none;
        case ServiceSocket::ReceiveResult::gone:
          return Answer::gone;
        case ServiceSocket::ReceiveResult::garbled:
          return Answer::garbled;
        case ServiceSocket::ReceiveResult::message:
          --owed_;
      }
    }
    return Answer::whole;
  }

  Answer answer(const Command& on_hand, DeviceReading& reading,
                Nanoseconds latest) noexcept override {
    if (const Answer heard = hear(latest); heard != Answer::whole) return heard;
    const auto message = read_message(socket_.message(), id_);
    if (!message) return Answer::garbled;
    const HaplyState& told = message->told;
    // neutral() detects a changed profile, but only if the service reports its profile.
    if (!told.position || told.calibrated == false || told.ready == false || !told.neutral() ||
        told.position->norm() > kFarthest)
      return Answer::garbled;
    reading.pose.position = turned_to_ours(*told.position - Vec3(0.0, kAway, kUp));
    if (turns_ && message->orientation) orientation_ = turned_to_ours(*message->orientation);
    reading.pose.orientation = orientation_;
    for (std::size_t i = 0; message->buttons && i < message->buttons->size(); ++i)
      reading.buttons |= (*message->buttons)[i] ? 1U << i : 0U;
    reading.deadman = message->buttons && (*message->buttons)[0];
    reading.clutch = message->buttons && (*message->buttons)[1];
    if (cut_) reading.held = held_command(on_hand, *cut_, Vec3::Zero());
    return take_force(on_hand, told.force) ? Answer::whole : Answer::garbled;
  }

  /// Compares the force that the service reports with the newest command, a part of it, and the
  /// previous command. Returns false for any other force, because another program then also
  /// controls the device.
  bool take_force(const Command& on_hand, const std::optional<Vec3>& told) noexcept {
    cut_.reset();
    if (!told) return true;
    const Vec3 applied = turned_to_ours(*told);
    const auto near = [&](const Vec3& force) { return length(applied - force) <= kSmallForce; };
    if (near(asked_for_) || near(on_hand.force())) return true;
    const double square = asked_for_.squaredNorm();
    const double share = square > 0.0 ? applied.dot(asked_for_) / square : -1.0;
    if (share < 0.0 || share > 1.0 || !near(share * asked_for_)) return false;
    cut_ = share * asked_for_;
    return true;
  }

  bool forget() noexcept override {
    for (int n = 0; n < kAnswers; ++n) {
      const ServiceSocket::ReceiveResult news = socket_.receive(Nanoseconds(0));
      if (news == ServiceSocket::ReceiveResult::gone) return false;
      if (news == ServiceSocket::ReceiveResult::none) break;
    }
    owed_ = 0;
    cut_.reset();
    return true;
  }

  void take_inventory(const std::string& id) {
    if (socket_.receive(monotonic_now() + kPatience) != ServiceSocket::ReceiveResult::message)
      refuse_service("the service says nothing of its devices; restart it");
    const auto message = read_message(socket_.message(), id);
    if (!message && !lists_devices(socket_.message()))
      refuse_service(
          "the service does not speak the JSON of version 3, as the older 2.x; install "
          "haply-inverse-service 3.1 or newer");
    if (!message)
      refuse_service((id.empty() ? std::string("the service has no Inverse3 or Minverse")
                                 : "the service has no device '" + id + "'") +
                     "; plug it in and look for it in the Haply Hub");
    const HaplyState& told = message->told;
    if (told.id.size() > kMostId || told.id.find_first_of("\"\\") != std::string_view::npos)
      refuse_service("the service sends an invalid device id; install a newer service");
    id_ = told.id;
    dialect_ = message->dialect;
    if (dialect_ == Dialect::keyed)
      refuse_service(
          "this port speaks the JSON of version 3.0, as newer services do at port 10000 for old "
          "programs; use port 10001 (haply, or haply:ID@10001), and if it is that, install "
          "haply-inverse-service 3.1 or newer");
    if (told.calibrated == false)
      refuse_service(
          "device " + id_ +
          " is not calibrated; move it by hand as its quick start shows, and start again");
    if (told.ready == false)
      refuse_service("device " + id_ + " is not ready; see its power and what the Haply Hub says");
    if (!told.neutral())
      refuse_service(
          "the service turns, moves, scales or damps the device's space; reset basis and mount of "
          "the profile in the Haply Hub, set its damping to 0, and use feltwire's own mapping");
    if (told.powered == false)
      notes_.emplace_back(
          "the service says that the device's power supply is not there: plug it in, or the force "
          "may be weak. What the service says that it applies is accounted");
    if (told.in_use == true)
      notes_.emplace_back(
          "the service says that another program uses the device; end it, for forces add up");
    if (told.left_handed)
      notes_.emplace_back(
          "it is a left-handed device: its axes are taken to be those of a right-handed one. See "
          "with a small --max-force that the tool follows the hand");
    if (dialect_ == Dialect::values)
      notes_.emplace_back(
          "this version of the service does not tell of its damping and its force gate: what it "
          "says that it applies is accounted");
    turns_ = message->orientation.has_value();
    if (turns_) {
      described_.spec.rotation_sensed = 3;
      notes_.emplace_back(
          "the tool turns as the grip of the service does, whose axes are an assumption. A grip "
          "that sleeps keeps its last orientation, and nothing tells");
    }
    if (message->devices > 1 && id.empty())
      notes_.push_back("the first of " + std::to_string(message->devices) +
                       " devices of the service is used, " + visible(id_));
    if (told.gate)
      notes_.emplace_back(
          "the service's force gate is on, by a law that is not known: what it says that it "
          "applies "
          "is accounted");
    notes_.emplace_back(told.compensates_gravity
                            ? "gravity compensation is on: the service holds the arm's weight, and "
                              "that force is not accounted"
                            : "gravity compensation is off, or the service does not say: the arm "
                              "may pull down. hand_force of the specification must have its weight "
                              "in it");
    std::array<char, kMostCommand> text{};
    const std::size_t size = write_command(dialect_, id_, Vec3::Zero(), false, text);
    zero_ = socket_.frame({text.data(), size});
  }

  void see_to_answers() {
    bool first = true;
    const Nanoseconds usual = measure_answers([&] {
      const Nanoseconds latest = monotonic_now() + kPatience;
      if (!say(Vec3::Zero(), std::exchange(first, false)) || hear(latest) != Answer::whole)
        refuse_service("the service does not answer a command; restart it");
    });
    if (usual > kSlowest)
      refuse_service("the service takes " + std::to_string(usual / milliseconds(1)) +
                     " ms to answer; end other programs that use it");
  }

  ServiceSocket socket_;
  std::vector<std::string> notes_;
  std::string id_;
  Dialect dialect_ = Dialect::values;
  ServiceSocket::Frame zero_;
  bool turns_ = false;  // whether a grip reports its orientation

  // Only the servo thread uses these members.
  int owed_ = 0;                                     // number of outstanding answers
  Quaternion orientation_ = Quaternion::Identity();  // newest received orientation
  Vec3 asked_for_ = Vec3::Zero();                    // [N] force of the newest command
  std::optional<Vec3> cut_;  // [N] reduced force, if the service reduced the newest command
};

}  // namespace
}  // namespace haply

namespace {

/// Returns the result of ask(). If ask() throws because the service is unreachable, adds the remedy
/// to the error.
template <class Ask>
auto asked_of_service(Ask ask) {
  try {
    return ask();
  } catch (const std::runtime_error& error) {
    const std::string why = error.what();
    if (why.starts_with("haply: ")) throw;
    haply::refuse_service(why +
                          "; is the service running (systemctl status haply-inverse-service)?");
  }
}

}  // namespace

OpenedDevice open_haply(const DeviceRequest& request) {
  const haply::Place place = haply::place_of(request.name);
  return asked_of_service([&]() -> OpenedDevice {
    auto device = std::make_unique<haply::HaplyDevice>(place, request);
    std::vector<std::string> notes = device->notes();
    return {std::move(device), std::move(notes)};
  });
}

std::string haply_service(std::uint16_t port) {
  return asked_of_service([&]() -> std::string {
    ServiceSocket socket(port, haply::kLongestMessage);
    const std::string text = "service at port " + std::to_string(port) + ", ";
    if (socket.receive(monotonic_now() + haply::kPatience) != ServiceSocket::ReceiveResult::message)
      haply::refuse_service(text + "says nothing of its devices; restart it");
    const auto message = haply::read_message(socket.message(), "");
    if (!message) return text + "no device";
    const bool waits = message->told.calibrated == false;
    return text + "first device " + visible(message->told.id) + " of " +
           std::to_string(message->devices) + (waits ? ", not calibrated" : "");
  });
}

std::string haply_usual_service() { return haply_service(haply::kUsualPort); }

}  // namespace feltwire
