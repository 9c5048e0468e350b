#include "client/drivers/haply/hapi.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <utility>

#include "client/device/assumed_transmission.hpp"
#include "client/device/held_command.hpp"
#include "client/device/lock_step.hpp"
#include "client/drivers/haply/hapi_board.hpp"
#include "client/drivers/haply/serial_port.hpp"
#include "core/base/numeric.hpp"
#include "core/device/spec_text.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace hapi {
namespace {

using std::chrono::milliseconds;

constexpr Nanoseconds kWakesUp = milliseconds(3000);
constexpr Nanoseconds kAsksAgain = milliseconds(300);
constexpr int kTrials = 50;
constexpr int kLetGoTrials = 3;      // further zero frames at the end
constexpr double kFastest = 400.0;   // [rad/s] largest speed of an arm
constexpr double kMostTorque = 1.0;  // largest torque; the board's unit is about 0.5 N m

[[noreturn]] void refuse(const std::string& why) { throw std::runtime_error("hapi: " + why); }

/// The maker's axes are x along the shafts and y towards the user. Feltwire's axes are x towards
/// the user and y right, with the origin in the centre of the workspace.
constexpr double kAhead = 0.08, kBeside = 0.01;  // [m] workspace centre along the maker's y, x
Vec3 ours(const Vec2& theirs) { return {theirs.y() - kAhead, theirs.x() - kBeside, 0.0}; }
Vec2 theirs(const Vec3& ours) { return {ours.y(), ours.x()}; }

class HapiDevice final : public LockStepDevice {
 public:
  explicit HapiDevice(const DeviceRequest& request)
      : LockStepDevice(sourced_spec("hapi_2dof"), request.spec), port_(request.name) {
    described_.spec.translation_dof = 2;
    assume_transmission(described_, kUnknownDrive);
    notes_ = assumptions(described_);
    set_up();
    see_to_answers();
    notes_.emplace_back(kTickNote);
    notes_.emplace_back(
        "the board's torque is not calibrated: a newton of feltwire is some force on the handle");
    notes_.emplace_back(
        "the board is not known to have a watchdog: a program that is killed, or a cable that is "
        "pulled, may leave the last force on the hand. Keep the power's switch at hand");
  }
  ~HapiDevice() override {
    release();
    // A frame can be lost on the way, and the board would then hold its force for good.
    for (int n = 0; n < kLetGoTrials; ++n) {
      rest(monotonic_now() + kPeriod);
      let_go();
    }
    port_.wait(monotonic_now() + kQuiet);
  }
  HapiDevice(const HapiDevice&) = delete;
  HapiDevice& operator=(const HapiDevice&) = delete;

  std::vector<std::string> notes() const { return notes_; }

 private:
  /// Writes zero torques. Makes one or two system calls.
  void let_go() noexcept override {
    static constexpr std::array<std::uint8_t, kTorqueBytes> kZeros{};
    if (const std::size_t torn = torn_.load(); torn > 0) {
      const std::size_t filled = port_.write(std::span(kZeros).first(torn)).value_or(0);
      torn_.store(torn - filled);
      if (filled != torn) return;  // the board would read further zeros as the rest of this frame
    }
    const auto frame = torque_frame(Vec2::Zero());
    port_.write(frame);
  }

  std::optional<Command> send(const Command& command) noexcept override {
    const Vec3 force = command.force();
    Vec2 torque = torque_of(tool_, theirs(force));
    const double share = std::min(1.0, kMostTorque / std::max(torque.norm(), kMostTorque));
    torque *= share;
    const auto frame = torque_frame(torque);
    if (!post(frame)) return std::nullopt;
    return held_command(command, share * force, Vec3::Zero());
  }

  /// Writes a frame. If the last frame was partly written, first completes it with zero bytes,
  /// which keep its torques small. Returns false if the frame was not written completely.
  bool post(std::span<const std::uint8_t> frame) noexcept {
    static constexpr std::array<std::uint8_t, kSetupBytes> kZeros{};
    reply_.clear();
    const std::size_t torn = torn_.load();
    const std::size_t filled =
        torn > 0 ? port_.write(std::span(kZeros).first(torn)).value_or(0) : 0;
    torn_.store(torn - filled);
    if (filled != torn) return false;
    const std::size_t written = port_.write(frame).value_or(0);
    if (written > 0) torn_.store(frame.size() - written);
    return written == frame.size();
  }

  /// Reads the board's answer of `expected` bytes. Waits for it until `latest` at most.
  Answer collect(std::size_t expected, Nanoseconds latest) noexcept {
    std::array<std::uint8_t, 64> room{};
    while (true) {
      const auto count = port_.read(room);
      if (!count) return Answer::gone;
      reply_.add(std::span(room).first(*count));
      if (reply_.garbled(expected)) return Answer::garbled;
      if (*count == room.size()) continue;
      if (reply_.size() == expected) return Answer::whole;
      if (monotonic_now() >= latest) return Answer::none;
      port_.wait(latest);
    }
  }

  Answer answer(const Command&, DeviceReading& reading, Nanoseconds latest) noexcept override {
    const Answer got = collect(kAngleReplyBytes, latest);
    if (got != Answer::whole) return got;
    const auto angles = reply_.angles();
    if (!angles || !take_angles(*angles)) return Answer::garbled;
    reading.pose.position = ours(tool_.position);
    return got;
  }

  /// Stores the arm angles and the tool position. Returns false if they are impossible, for example
  /// if an arm would have moved too fast.
  bool take_angles(const Vec2& angles) noexcept {
    const Nanoseconds now = monotonic_now();
    const double most = kFastest * seconds(now - taken_at_);
    const bool possible =
        taken_at_.count() == 0 || (angles - angles_).cwiseAbs().maxCoeff() <= most;
    const auto tool = tool_point(angles);
    if (!possible || !tool) return false;
    taken_at_ = now;
    angles_ = angles;
    tool_ = *tool;
    return true;
  }

  bool forget() noexcept override {
    std::array<std::uint8_t, 256> room{};
    taken_at_ = Nanoseconds(0);
    for (int n = 0; n < kTrials; ++n) {
      const auto count = port_.read(room);
      if (!count) return false;
      if (*count == 0) break;
    }
    reply_.clear();
    return true;
  }

  void set_up() {
    const Nanoseconds latest = monotonic_now() + kWakesUp;
    bool answered = false;
    while (monotonic_now() < latest) {
      if (!forget()) refuse("the port was unplugged");
      post(setup_frame());
      const Answer got = collect(kSetupReplyBytes, monotonic_now() + kAsksAgain);
      if (got == Answer::whole) return;
      answered |= got == Answer::garbled;
      // Wait for the end of the garbled answer.
      if (got == Answer::garbled) rest(monotonic_now() + kQuiet);
    }
    refuse(answered
               ? "the device at the port is not a board with hAPI firmware, or its firmware is of "
                 "another version; install the firmware whose frames begin with 0x03 and 0x13"
               : "no answer at the port within 3 s; check that it is the board's port, and that "
                 "its firmware is the hAPI's (frames that begin with 0x03 and 0x13)");
  }

  /// Measures the usual answer time of the board at zero force.
  void see_to_answers() {
    const Nanoseconds usual = measure_answers([this] {
      const Nanoseconds latest = monotonic_now() + kAsksAgain;
      post(torque_frame(Vec2::Zero()));
      if (collect(kAngleReplyBytes, latest) != Answer::whole || !reply_.angles())
        refuse("the board answered its setup, and then not a frame of torques; plug it in anew");
    });
    if (!tool_point(*reply_.angles()))
      refuse(
          "the elbows of the pantograph meet, and where the tool is cannot be known; hold both "
          "arms "
          "straight out to the sides, away from each other, and start again");
    if (usual > kSlowest)
      refuse("the board takes " + std::to_string(usual / milliseconds(1)) +
             " ms to answer; plug it into a port of the machine itself");
  }

  SerialPort port_;
  std::vector<std::string> notes_;
  std::atomic<std::size_t> torn_{0};  // number of bytes that the newest frame lacks

  // Only the servo thread uses these members.
  Reply reply_;
  Nanoseconds taken_at_{0};
  Vec2 angles_ = Vec2::Zero();  // [rad] newest arm angles
  ToolPoint tool_{.position = Vec2::Zero(), .jacobian = Mat2::Zero()};
};

}  // namespace
}  // namespace hapi

OpenedDevice open_hapi(const DeviceRequest& request) {
  auto device = std::make_unique<hapi::HapiDevice>(request);
  std::vector<std::string> notes = device->notes();
  return {std::move(device), std::move(notes)};
}

}  // namespace feltwire
