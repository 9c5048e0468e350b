// Draws the hands and bodies of a scene as text, seen from above, four times a second.
//
//   my_scene_viewer localhost:6720 room 10       runs for 10 s; 0: until Ctrl-C
//
// The program needs a token for an observer. This command makes the token:
//
//   feltwire-server token add --client eye --role observer
//
// A digit shows a hand, and an o shows a body. The forces on the hands are printed below the map.

#include <cstdio>
#include <cstdlib>
#include <feltwire/client/hands/simulated_device.hpp>
#include <feltwire/client/run/run_client.hpp>
#include <string>
#include <vector>

class Map {
 public:
  void operator()(double time, const feltwire::ObservedScene& scene) {
    if (time < next_) return;
    next_ = time + 0.25;
    std::vector<std::string> rows(kRows, std::string(kColumns, '.'));
    const auto put = [&](const feltwire::Vec3& at, char sign) {
      const double column = (at.x() / kWidth + 0.5) * kColumns;
      const double row = (0.5 - at.y() / kWidth) * kRows;
      if (!(column >= 0.0 && column < kColumns && row >= 0.0 && row < kRows)) return;
      rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] = sign;
    };
    for (const auto& [object, body] : scene.bodies()) put(body.pose.position, 'o');
    for (const auto& [number, hand] : scene.hands())
      put(hand.pose.position, static_cast<char>('0' + number % 10));
    std::printf("%.2f s, %zu hands, %zu bodies, %.1f m wide\n", time, scene.hands().size(),
                scene.bodies().size(), kWidth);
    for (const std::string& row : rows) std::printf("%s\n", row.c_str());
    for (const auto& [number, hand] : scene.hands())
      std::printf("hand %u: %.2f N\n", number, hand.force.norm());
    std::fflush(stdout);
  }

 private:
  static constexpr int kColumns = 60, kRows = 20;
  static constexpr double kWidth = 0.4;  // [m] width of the drawn area
  double next_ = 0.0;                    // [s] time of the next drawing
};

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: my_scene_viewer HOST:PORT SCENE SECONDS\n"), 2;
  feltwire::RunOptions options;
  options.server = feltwire::access_from_environment(argv[1]);
  options.name = options.device_kind = "my_scene_viewer";
  options.scene = argv[2];
  options.duration = std::atof(argv[3]);
  options.role = feltwire::Role::observer;
  options.parameters.packet_interval = 33;  // [servo ticks] between packets: 30 packets per second
  options.hooks.on_view = Map();
  // run_client() needs a device. An observer has no hand in the scene, so this device does not move
  // and gets no force.
  feltwire::SimulatedHandOptions nobody;
  nobody.spec = feltwire::builtin_device("simulated");
  return feltwire::run_client(std::make_unique<feltwire::SimulatedDevice>(nobody), options);
} catch (const std::exception& error) {
  std::fprintf(stderr, "my_scene_viewer: %s\n", error.what());
  return 1;
}
