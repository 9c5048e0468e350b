#include "client/drivers/open_haptics/open_haptics.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>
#include <utility>

#include "client/device/assumed_transmission.hpp"
#include "client/device/connection_lag.hpp"
#include "client/device/sample_mailbox.hpp"
#include "client/drivers/common/shared_library.hpp"
#include "core/device/spec_text.hpp"

namespace feltwire {
namespace hd {
namespace {

namespace fs = std::filesystem;

// Constants of the HD API. Users of the API have published these values.
constexpr unsigned kNoHandle = 0xFFFFFFFFu;
constexpr unsigned kContinue = 1;
constexpr unsigned short kUsualPriority = 32767;
constexpr unsigned kForceOutput = 0x4000, kForceRamping = 0x4002;  // arguments of hdEnable
constexpr unsigned kButtons = 0x2000, kInkwell = 0x2002, kTransform = 0x2052, kModel = 0x2501,
                   kOutputDof = 0x2554, kUpdateRate = 0x2600, kNominalMaxForce = 0x2603;
constexpr unsigned kCurrentForce = 0x2700, kCurrentTorque = 0x2701;
constexpr int kForceAndTorque = 6;  // value of kOutputDof for a device with wrist motors
constexpr unsigned kCalibrated = 0x5000, kNeedsUpdate = 0x5001;  // results of hdCheckCalibration
constexpr unsigned kAutomatic = 2, kByInkwell = 4;               // calibration styles
// Errors from this code on mean that the force differs from the command: warm motors, force or
// speed limits, device faults, a late scheduler, an unfinished frame.
constexpr unsigned kFirstFault = 0x200;

constexpr Nanoseconds kPatience =
    std::chrono::microseconds(300);  // longest wait of the callback for the servo
// Largest number of ticks that repeat a force without a new command.
constexpr int kMostRepeated = 25;
// [ticks] Duration of the library's force ramp, at the start and after an error.
constexpr int kRampTicks = 1000;
constexpr double kMillimetre = 1e-3;
constexpr double kMilli = 1e3;  // mN m per N m, because the API takes torque in mN m

struct ErrorInfo {
  unsigned code;
  int internal;
  unsigned device;
};

[[noreturn]] void refuse(const std::string& why) {
  throw std::runtime_error("openhaptics: " + why);
}

struct Calls {
  using Callback = unsigned(void*);
  explicit Calls(const SharedLibrary& l)
      : init(l.get<unsigned(const char*)>("hdInitDevice")),
        disable_device(l.get<void(unsigned)>("hdDisableDevice")),
        make_current(l.get<void(unsigned)>("hdMakeCurrentDevice")),
        begin(l.get<void(unsigned)>("hdBeginFrame")),
        end(l.get<void(unsigned)>("hdEndFrame")),
        error(l.get<ErrorInfo()>("hdGetError")),
        error_text(l.get<const char*(unsigned)>("hdGetErrorString")),
        enable(l.get<void(unsigned)>("hdEnable")),
        disable(l.get<void(unsigned)>("hdDisable")),
        get_doubles(l.get<void(unsigned, double*)>("hdGetDoublev")),
        get_integers(l.get<void(unsigned, int*)>("hdGetIntegerv")),
        get_booleans(l.find<void(unsigned, unsigned char*)>("hdGetBooleanv")),
        get_string(l.get<const char*(unsigned)>("hdGetString")),
        set_doubles(l.get<void(unsigned, const double*)>("hdSetDoublev")),
        calibration(l.get<unsigned()>("hdCheckCalibration")),
        calibration_style(l.get<unsigned()>("hdCheckCalibrationStyle")),
        calibrate(l.get<void(unsigned)>("hdUpdateCalibration")),
        start(l.get<void()>("hdStartScheduler")),
        stop(l.get<void()>("hdStopScheduler")),
        schedule(l.get<unsigned long(Callback*, void*, unsigned short)>("hdScheduleAsynchronous")),
        unschedule(l.get<void(unsigned long)>("hdUnschedule")) {}

  unsigned (*init)(const char*);
  void (*disable_device)(unsigned);
  void (*make_current)(unsigned);
  void (*begin)(unsigned);
  void (*end)(unsigned);
  ErrorInfo (*error)();
  const char* (*error_text)(unsigned);
  void (*enable)(unsigned);
  void (*disable)(unsigned);
  void (*get_doubles)(unsigned, double*);
  void (*get_integers)(unsigned, int*);
  void (*get_booleans)(unsigned, unsigned char*);  // null if the library lacks it
  const char* (*get_string)(unsigned);
  void (*set_doubles)(unsigned, const double*);
  unsigned (*calibration)();
  unsigned (*calibration_style)();
  void (*calibrate)(unsigned);
  void (*start)();
  void (*stop)();
  unsigned long (*schedule)(Callback*, void*, unsigned short);
  void (*unschedule)(unsigned long);
};

SharedLibrary load() {
  std::vector<fs::path> files;
  if (const char* root = std::getenv("OH_SDK_BASE"))
    for (const char* folder : {"lib", "usr/lib"})
      files.push_back(fs::path(root) / folder / "libHD.so");
  files.insert(files.end(), {"libHD.so", "libHD.so.3.4", "libHD.so.3.0"});
  try {
    SharedLibrary library = SharedLibrary::first_of(files);
    [[maybe_unused]] const Calls all(library);
    return library;
  } catch (const std::runtime_error& error) {
    refuse(
        std::string("the maker's library cannot be used: ") + error.what() +
        "; install OpenHaptics 3 and the Touch driver (libPhantomIOLib42.so comes with the driver; "
        "libHD 3.0 needs libncurses5), and set OH_SDK_BASE where it is not in /usr/lib");
  }
}

/// Returns the rotation from the maker's axes (x right, y up, z towards the user) to feltwire's
/// axes (x towards the user, y right, z up).
Mat3 turned() {
  Mat3 turn;
  turn << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return turn;
}

class OpenHapticsDevice final : public Device {
 public:
  OpenHapticsDevice(SharedLibrary library, const DeviceRequest& request)
      : library_(std::move(library)), call_(library_), mailbox_(kMostRepeated), turn_(turned()) {
    handle_ = opened(request.name);
    try {
      prepare(request);
    } catch (...) {
      call_.disable_device(handle_);
      throw;
    }
  }
  ~OpenHapticsDevice() override {
    constexpr int kTicks = 50;
    mailbox_.release();
    for (int n = 0; n < kTicks && !let_go_; ++n)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    call_.unschedule(task_);
    call_.stop();
    call_.disable(kForceOutput);
    call_.disable_device(handle_);
  }
  OpenHapticsDevice(const OpenHapticsDevice&) = delete;
  OpenHapticsDevice& operator=(const OpenHapticsDevice&) = delete;

  const DeviceSpec& spec() const override { return described_.spec; }
  std::vector<std::string> notes() const { return notes_; }
  Nanoseconds longest_tick() const override { return longest_tick_; }
  std::string_view prepare() noexcept override {
    return in_inkwell_.load() ? "take the stylus out of its inkwell" : "";
  }

  bool await_tick(Nanoseconds latest) noexcept override { return mailbox_.await(latest); }
  DeviceReading read(Nanoseconds) noexcept override { return mailbox_.newest(); }
  Command write(const Command& on_hand) noexcept override { return mailbox_.write(on_hand); }
  /// Requests the release. The callback releases the device at its next tick.
  void release() noexcept override { mailbox_.release(); }

 private:
  unsigned opened(const std::string& name) const {
    while (call_.error().code != 0) continue;  // discard old errors
    std::vector<const char*> names = {nullptr, "Default Device", "Default PHANToM"};
    if (!name.empty()) names = {name.c_str()};
    std::string why = "no reason";
    for (const char* one : names) {
      const unsigned handle = call_.init(one);
      const ErrorInfo error = call_.error();
      if (handle != kNoHandle && error.code == 0) return handle;
      const char* text = call_.error_text(error.code);
      why = text != nullptr ? text : "no reason";
      while (call_.error().code != 0) continue;
    }
    refuse("the device " + (name.empty() ? std::string("(the default one)") : "'" + name + "'") +
           " cannot be opened: " + why +
           "; run the maker's Touch Setup once, see that the node (/dev/ttyACM* or /dev/hidraw*) "
           "may be "
           "read and written by you, and delete ~/.3dsystems/config after a change of driver");
  }

  void prepare(const DeviceRequest& request) {
    call_.make_current(handle_);
    const char* name = call_.get_string(kModel);
    const std::string model = name != nullptr ? name : "";
    const bool premium = model.find("Premium") != std::string::npos;
    int outputs = 0;
    call_.get_integers(kOutputDof, &outputs);
    const bool actuated = premium && outputs == kForceAndTorque;
    SourcedSpec found = sourced_spec(actuated  ? "phantom_premium_1.5_6dof"
                                     : premium ? "phantom_premium_1.5"
                                               : "touch");
    double most = 0.0;
    call_.get_doubles(kNominalMaxForce, &most);
    if (most > 0.0) {
      found.spec.max_force = most;
      found.spec.continuous_force = std::min(found.spec.continuous_force, most);
      found.sources["max_force"] = "the device";
    }
    described_ = request.spec.name_or_file.empty() ? overruled(std::move(found), request.spec)
                                                   : requested_spec(request.spec, "");
    // No call reports the connection. A Premium uses a card or a parallel port, a Touch uses USB or
    // Ethernet.
    const bool touch = model.find("Touch") != std::string::npos;
    assume_lag(described_, premium ? kMappedConnection
                           : touch ? kUsbConnection
                                   : kUnknownConnection);
    assume_transmission(described_, premium ? kCableDrive : kSmallCableDrive);
    described_.spec.rotation_sensed = 3;
    torque_ = actuated && described_.spec.rotation_actuated > 0;
    if (!torque_) {
      described_.spec.rotation_actuated = 0;
      described_.spec.max_torque = 0.0;
    }
    notes_ = assumptions(described_);
    if (!premium && !touch)
      notes_.push_back("the model '" + model +
                       "' is not known here; its specification is that of a Touch. Give --spec");
    notes_.emplace_back(
        "the maker's library ramps the force up at the start and after an error: no force is given "
        "for a second then");
    notes_.emplace_back(
        "the maker promises no longest tick: 1.25 times the usual one is an assumption; a later "
        "tick is an overrun in the report");
    notes_.emplace_back(
        "nothing tells whether the stylus's weight is compensated: hand_force of the specification "
        "must have it in it");
    int rate = 0;
    call_.get_integers(kUpdateRate, &rate);
    constexpr int kUsualRate = 1000;
    // Ratio of the longest tick to the usual period. It allows for the scheduler's jitter.
    constexpr double kSlack = 1.25;
    longest_tick_ = from_seconds(kSlack / (rate > 0 ? rate : kUsualRate));
    calibrate();
    has_inkwell_ = call_.get_booleans != nullptr && (call_.calibration_style() & kByInkwell) != 0;
    in_inkwell_.store(has_inkwell_ && is_in_inkwell());
    call_.enable(kForceRamping);
    call_.enable(kForceOutput);
    task_ = call_.schedule(&OpenHapticsDevice::called_back, this, kUsualPriority);
    call_.start();
    const ErrorInfo error = call_.error();
    if (error.code == 0) return;
    const char* text = call_.error_text(error.code);
    call_.unschedule(task_);
    call_.stop();
    refuse(std::string("its scheduler does not start: ") + (text != nullptr ? text : "no reason"));
  }

  void calibrate() const {
    unsigned state = call_.calibration();
    if (state == kNeedsUpdate && (call_.calibration_style() & kAutomatic) != 0) {
      call_.calibrate(kAutomatic);
      state = call_.calibration();
    }
    if (state != kCalibrated)
      refuse(
          "the device is not calibrated; put the stylus into its inkwell (Premium: hold all links "
          "at right angles), run the maker's diagnosis program, and start again");
  }

  bool is_in_inkwell() const noexcept {
    unsigned char in = 0;
    call_.get_booleans(kInkwell, &in);
    return in != 0;
  }

  /// Runs a frame. The thread of the maker's scheduler calls this function.
  static unsigned called_back(void* self) {
    static_cast<OpenHapticsDevice*>(self)->frame();
    return kContinue;
  }

  /// Reads the device. Call this only within a frame of the maker's library.
  DeviceReading sensed(bool in_inkwell) const noexcept {
    std::array<double, 16> transform{};  // 4 x 4 matrix; the last column is the translation [mm]
    call_.get_doubles(kTransform, transform.data());
    DeviceReading reading;
    reading.pose.position =
        kMillimetre * (turn_ * Vec3(transform[12], transform[13], transform[14]));
    const Eigen::Map<const Eigen::Matrix4d> placed(transform.data());  // column-major
    const Mat3 axes = placed.topLeftCorner<3, 3>();
    reading.pose.orientation = Quaternion(Mat3(turn_ * axes * turn_.transpose()));
    reading.ok = !failed_;
    int pressed = 0;
    call_.get_integers(kButtons, &pressed);
    reading.buttons = static_cast<std::uint32_t>(pressed);
    reading.deadman = (pressed & 1) != 0;
    reading.clutch = (pressed & 2) != 0;
    if (ramping_ > 0) reading.withheld = Withheld::starting;
    if (in_inkwell) reading.withheld = Withheld::in_inkwell;
    return reading;
  }

  void frame() noexcept {
    call_.begin(handle_);
    const bool in_inkwell = has_inkwell_ && is_in_inkwell();
    in_inkwell_.store(in_inkwell);
    Command given = mailbox_.exchange(sensed(in_inkwell), kPatience);
    if (ramping_ > 0 || in_inkwell) {
      given = {};
      mailbox_.cut_to(given);
    }
    const Vec3 force = turn_.transpose() * given.force();
    call_.set_doubles(kCurrentForce, force.data());
    if (torque_) {
      const Vec3 torque = kMilli * (turn_.transpose() * given.torque);
      call_.set_doubles(kCurrentTorque, torque.data());
    }
    call_.end(handle_);
    if (mailbox_.released()) let_go_.store(true);
    look_for_errors();
  }

  /// Reads the library's errors. After a fault, the library ramps the force up. During the ramp the
  /// force on the hand is unknown, so the driver commands zero force.
  void look_for_errors() noexcept {
    constexpr int kMost = 32;
    ramping_ = std::max(0, ramping_ - 1);
    failed_ = false;
    for (int n = 0; n < kMost; ++n) {
      const unsigned code = call_.error().code;
      if (code == 0) break;
      failed_ |= code >= kFirstFault;
    }
    if (failed_) ramping_ = kRampTicks;
  }

  SharedLibrary library_;
  Calls call_;
  SampleMailbox mailbox_;
  Mat3 turn_;
  unsigned handle_ = kNoHandle;
  unsigned long task_ = 0;
  SourcedSpec described_;
  std::vector<std::string> notes_;
  Nanoseconds longest_tick_{0};
  bool has_inkwell_ = false;
  bool torque_ = false;  // whether the session uses wrist motors
  std::atomic<bool> let_go_{false}, in_inkwell_{false};
  // Only the scheduler's thread uses these members.
  int ramping_ = kRampTicks;
  bool failed_ = false;  // whether the last frame failed, so that the force on the hand is unknown
};

}  // namespace
}  // namespace hd

OpenedDevice open_haptics(const DeviceRequest& request) {
  auto device = std::make_unique<hd::OpenHapticsDevice>(hd::load(), request);
  std::vector<std::string> notes = device->notes();
  return {std::move(device), std::move(notes)};
}

std::string open_haptics_library() { return hd::load().loaded_from().string(); }

}  // namespace feltwire
