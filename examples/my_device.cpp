// Connects your own device to a scene, with a class for the device and a call of run_client().
//
//   feltwire-server --scene scenes/room.json
//   export FELTWIRE_FINGERPRINT_FILE=~/.local/state/feltwire/fingerprint
//   export FELTWIRE_TOKEN_FILE=~/.local/state/feltwire/local.token
//   my_device localhost:6720 room 5          runs for 5 s; 0: until Ctrl-C
//   my_device localhost:6720 room 5 0.1      on a busy machine: releases the device after 0.1 s
//                                            without a servo tick. Use 0.005 (5 ms) if a person
//                                            holds the device.
//
// The device in this example is a simulated handle on a spring. For a real device, replace the
// three lines that move the handle by calls to the library of the device's manufacturer.

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <feltwire/client/run/run_client.hpp>

class MyDevice final : public feltwire::Device {
 public:
  MyDevice() {
    spec_.name = "my_device";
    spec_.damping = 2.0;           // b [N s/m] viscous damping of the device itself: measure it
    spec_.apparent_mass = 0.2;     // [kg]
    spec_.least_mass = 0.15;       // [kg] lower bound of the mass in all directions
    spec_.max_force = 6.0;         // [N]
    spec_.continuous_force = 2.0;  // [N]
    feltwire::validate(spec_);     // throws if a value is missing or contradicts another
  }

  const feltwire::DeviceSpec& spec() const override { return spec_; }

  /// Places the handle 1 cm above the surface of the scene. The spring pulls it to a point 1 cm
  /// below the surface.
  void begin(const feltwire::Vec3& position, const feltwire::Vec3& normal) override {
    position_ = position + 0.01 * normal;
    rest_ = position - 0.01 * normal;
  }

  feltwire::DeviceReading read(feltwire::Nanoseconds now) noexcept override {
    const double h = feltwire::seconds(now - last_);  // [s] time since the last reading
    if (last_.count() > 0 && h > 0.0 && h < 0.1) {
      const feltwire::Vec3 spring = 100.0 * (rest_ - position_) - 2.0 * velocity_;
      velocity_ += h / spec_.apparent_mass * (spring + force_);
      position_ += h * velocity_;
    }
    last_ = now;
    feltwire::DeviceReading reading;
    reading.pose.position = position_;  // [m], world frame
    return reading;
  }

  feltwire::Command write(const feltwire::Command& on_hand) noexcept override {
    const feltwire::Command held = released_ ? feltwire::Command{} : on_hand;
    force_ = held.force();  // [N]
    return held;
  }

  /// Sets a flag, so that write() gives no more force. Any thread and any signal handler may call
  /// release().
  void release() noexcept override { released_ = true; }

 private:
  feltwire::DeviceSpec spec_;
  feltwire::Vec3 position_{0, 0, 0.01}, velocity_{0, 0, 0}, rest_{0, 0, -0.01}, force_{0, 0, 0};
  feltwire::Nanoseconds last_{0};
  std::atomic<bool> released_{false};
};

int main(int argc, char** argv) try {
  if (argc != 4 && argc != 5)
    return std::fprintf(stderr, "usage: my_device HOST:PORT SCENE SECONDS [LET_GO_AFTER]\n"), 2;
  feltwire::RunOptions options;
  options.server = feltwire::access_from_environment(argv[1]);
  options.name = options.device_kind = "my_device";
  options.scene = argv[2];
  options.duration = std::atof(argv[3]);
  if (argc == 5) options.hold.let_go_after = std::atof(argv[4]);
  options.servo = feltwire::protect_hand(options.parameters);
  return feltwire::run_client(std::make_unique<MyDevice>(), options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "my_device: %s\n", error.what());
  return 1;
}
