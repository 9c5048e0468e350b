#include "client/drivers/novint/falcon.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "client/device/assumed_transmission.hpp"
#include "client/device/held_command.hpp"
#include "client/device/lock_step.hpp"
#include "client/drivers/novint/falcon_board.hpp"
#include "client/drivers/novint/falcon_firmware.hpp"
#include "client/drivers/novint/falcon_line.hpp"
#include "core/base/numeric.hpp"
#include "core/base/regular_file.hpp"
#include "core/device/spec_text.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace falcon {
namespace {

using std::chrono::milliseconds;

constexpr std::uint16_t kVendor = 0x0403, kProduct = 0xCB48;
constexpr int kMostDevices = 16;
constexpr std::size_t kMostFirmware = 1 << 16;  // [bytes] largest file; known images have 7 to 8 kB
// Largest number of attempts to load the firmware. Other users report that an attempt often fails.
constexpr int kLoads = 5;
constexpr int kAsks = 10;  // largest number of requests to detect a running firmware
constexpr Nanoseconds kAnswers = milliseconds(300);

[[noreturn]] void refuse(const std::string& why) { throw std::runtime_error("falcon: " + why); }

/// The maker's axes are x right, y up and z towards the user. Feltwire's axes are x towards the
/// user, y right and z up, with the origin in the centre of the workspace.
Vec3 turned_to_ours(const Vec3& v) { return {v.z(), v.x(), v.y()}; }
Vec3 turned_to_theirs(const Vec3& v) { return {v.y(), v.z(), v.x()}; }

int device_number(const std::string& name) {
  int number = 0;
  const auto* const end = name.data() + name.size();
  const auto parsed = std::from_chars(name.data(), end, number);
  const bool whole = name.empty() || (parsed.ec == std::errc() && parsed.ptr == end);
  if (!whole || number < 0 || number >= kMostDevices)
    refuse("'" + name + "' is no number of a device; give 0 to 15, or nothing for the first");
  return number;
}

std::unique_ptr<UsbLine> opened(int number) {
  try {
    return std::make_unique<UsbLine>(kVendor, kProduct, number);
  } catch (const std::runtime_error& error) {
    refuse(error.what());
  }
}

/// Returns whether a firmware runs: it answers a request with zero force.
bool answers(UsbLine& line) {
  if (!talk_to_firmware(line)) return false;
  const Packet asked = request({}, Light::red, false);
  for (int n = 0; n < kAsks; ++n) {
    Answer answer;
    const AnswerStatus heard = ask(line, asked, answer, {.send = kAnswers, .answer = kAnswers / 4});
    if (heard == AnswerStatus::gone || heard == AnswerStatus::unsent) return false;
    if (heard == AnswerStatus::whole && parse_reply(answer.packet())) return true;
    if (!talk_to_firmware(line)) return false;  // talk_to_firmware() also discards unread bytes
  }
  return false;
}

void see_to_firmware(UsbLine& line, const std::string& file) {
  if (answers(line)) return;
  if (file.empty())
    refuse(
        "it has no firmware: it forgets it whenever its power is off. Give --device "
        "falcon:firmware=FILE with "
        "the maker's image, which comes with the maker's driver; feltwire may not bring it");
  const std::string image = read_regular_file(file, kMostFirmware);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(image.data()), image.size());
  if (bytes.empty()) refuse(file + ": the file is empty");
  std::string wrong;
  for (int n = 0; n < kLoads; ++n) {
    wrong = load_firmware(line, bytes);
    if (!wrong.empty()) continue;
    if (answers(line)) return;
    wrong = "the firmware of " + file + " was loaded and does not answer; is it the Falcon's?";
  }
  refuse(wrong);
}

class FalconDevice final : public LockStepDevice {
 public:
  explicit FalconDevice(const DeviceRequest& request)
      : LockStepDevice(sourced_spec("falcon"), request.spec) {
    assume_transmission(described_, kCableDrive);
    notes_ = assumptions(described_);
    auto line = opened(device_number(request.name));
    see_to_firmware(*line, request.firmware);
    line_ = std::make_unique<FalconLine>(std::move(line));
    see_to_answers();
    notes_.emplace_back(kTickNote);
    notes_.emplace_back(
        "the motors' scale is not calibrated: a newton of feltwire is some force at the handle");
    notes_.emplace_back("gravity compensation is not there: the handle is light, and pulls down");
    notes_.emplace_back(
        "the firmware is not known to have a watchdog: a program that is killed, or a cable that "
        "is pulled, may leave the last force on the hand. Keep the power's switch at hand");
  }
  FalconDevice(const FalconDevice&) = delete;
  FalconDevice& operator=(const FalconDevice&) = delete;

  std::vector<std::string> notes() const { return notes_; }

  std::string_view prepare() noexcept override {
    const auto all = asked({}, kAnswers);
    if (!all) return "the device does not answer; plug it in anew";
    if (homed(*all)) return {};
    return "pull the handle all the way out, then push it all the way in";
  }

 private:
  static bool homed(const BoardReply& all) {
    return std::all_of(all.homed.begin(), all.homed.end(), [](bool one) { return one; });
  }
  Packet packet_of(const Counts& motors) const noexcept {
    return request(motors, homed_ ? Light::green : Light::red, !homed_);
  }

  /// Sends a request and returns its answer, or nothing after `patience`. Use this only before the
  /// servo starts.
  std::optional<BoardReply> asked(const Counts& motors, Nanoseconds patience) noexcept {
    line_->forget();
    line_->post(packet_of(motors));
    const FalconLine::LineAnswer news = line_->receive(monotonic_now() + patience);
    const auto all = news.kind == AnswerStatus::whole ? parse_reply(news.packet) : std::nullopt;
    if (all) homed_ = homed(*all);
    return all;
  }

  void let_go() noexcept override { line_->let_go(); }

  std::optional<Command> send(const Command& command) noexcept override {
    const Counts motors =
        homed_ ? motors_of(tool_.point(), turned_to_theirs(command.force())) : Counts{};
    if (!line_->post(packet_of(motors))) return std::nullopt;
    if (motors == Counts{}) return Command{};
    return held_command(command, turned_to_ours(force_of(tool_.point(), motors)), Vec3::Zero());
  }

  Answer answer(const Command&, DeviceReading& reading, Nanoseconds latest) noexcept override {
    const FalconLine::LineAnswer news = line_->receive(latest);
    switch (news.kind) {
      case AnswerStatus::none:
        return Answer::none;
      case AnswerStatus::gone:
        return Answer::gone;
      case AnswerStatus::unsent:
      case AnswerStatus::garbled:
        return Answer::garbled;
      case AnswerStatus::whole:
        break;
    }
    const auto all = parse_reply(news.packet);
    if (!all) return Answer::garbled;
    reading.buttons = all->buttons;
    reading.deadman = (all->buttons & 1U) != 0;
    reading.clutch = (all->buttons & 2U) != 0;
    homed_ = homed(*all);
    if (!homed_) {
      tool_.forget();
      reading.withheld = Withheld::not_homed;
      return Answer::whole;
    }
    if (!tool_.take(all->encoders, monotonic_now())) return Answer::garbled;
    reading.pose.position = turned_to_ours(tool_.point().position - kMiddle);
    return Answer::whole;
  }

  bool forget() noexcept override {
    line_->forget();
    tool_.forget();
    return line_->receive(Nanoseconds(0)).kind != AnswerStatus::gone;
  }

  void see_to_answers() {
    const Nanoseconds usual = measure_answers([this] {
      if (!asked({}, kAnswers)) refuse("it answered once, and then not; plug it in anew");
    });
    if (usual > kSlowest)
      refuse("it takes " + std::to_string(usual / milliseconds(1)) +
             " ms to answer; plug it into a port of the machine itself");
  }

  std::vector<std::string> notes_;
  bool homed_ = false;

  // Only the servo thread uses these members.
  TrackedTool tool_;
  std::unique_ptr<FalconLine> line_;
};

}  // namespace
}  // namespace falcon

OpenedDevice open_falcon(const DeviceRequest& request) {
  auto device = std::make_unique<falcon::FalconDevice>(request);
  std::vector<std::string> notes = device->notes();
  return {std::move(device), std::move(notes)};
}

std::string falcon_library() {
  try {
    return UsbLine::library();
  } catch (const std::runtime_error& error) {
    falcon::refuse(error.what());
  }
}

}  // namespace feltwire
