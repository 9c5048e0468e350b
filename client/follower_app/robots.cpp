#include "client/follower_app/robots.hpp"

#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "client/followers/socket_follower.hpp"
#include "client/simulated_robots/arm.hpp"
#include "client/simulated_robots/point_robot.hpp"
#include "client/simulated_robots/scene_surfaces.hpp"
#include "core/base/visible_text.hpp"
#include "core/scene_file/load_scene.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

std::string text(const Vec3& v) {
  std::ostringstream out;
  out << v.x() << ',' << v.y() << ',' << v.z();
  return out.str();
}

/// Returns an arm in its home pose, or at the position `at` if it is given. The movement to `at`
/// runs in simulated time, so the call does not wait for it.
std::unique_ptr<Follower> make_arm(const std::string& file, const std::optional<Vec3>& at) {
  constexpr double kNear = 2e-3;  // [m] largest distance from `at` after the movement
  ArmConfig config;
  config.file = file;
  auto arm = std::make_unique<Arm>(config);
  if (!at) return arm;
  Nanoseconds now = monotonic_now() - std::chrono::seconds(4);
  bring(*arm, *at, arm->spec().gripper_opening, now);
  const FollowerReading reading = arm->read(now);
  if (reading.ok && !reading.stopped && (reading.pose.position - *at).norm() <= kNear) return arm;
  throw std::invalid_argument("--at " + text(*at) + ": the arm of " + file + " comes only to " +
                              text(reading.pose.position) +
                              " [m]; give a place within its reach, free of what it touches");
}

std::unique_ptr<Follower> await_driver(const std::string& path, double patience) {
  FollowerListener listener(path);
  std::fprintf(stderr, "feltwire-follower: waits for a driver at %s\n", visible(path).c_str());
  return listener.wait(from_seconds(patience));
}

}  // namespace

void check(const RobotChoice& choice) {
  const int given = static_cast<int>(!choice.surroundings.empty()) +
                    static_cast<int>(!choice.arm.empty()) +
                    static_cast<int>(!choice.socket.empty());
  if (given != 1)
    throw std::invalid_argument(
        std::string(given == 0 ? "no robot is given" : "more than one robot is given") +
        "; give one of --surroundings FILE.json (a point), --arm FILE.xml (an arm), --socket PATH "
        "(a driver in another language)");
  if (choice.at && !choice.socket.empty())
    throw std::invalid_argument(
        "--at applies only to simulated robots; the driver at --socket reports its robot's place. "
        "Leave "
        "out --at");
  if (choice.at && !choice.at->allFinite())
    throw std::invalid_argument("--at must be three finite numbers [m]: X,Y,Z");
}

std::shared_ptr<SurfaceModel> load_surfaces(const std::string& file) {
  return std::make_shared<SceneSurfaces>(std::make_shared<const Scene>(load_scene(file)));
}

std::unique_ptr<Follower> make_robot(const RobotChoice& choice, double patience) {
  if (!choice.arm.empty()) return make_arm(choice.arm, choice.at);
  if (!choice.socket.empty()) return await_driver(choice.socket, patience);
  return std::make_unique<PointRobot>(
      std::make_shared<const Scene>(load_scene(choice.surroundings)),
      choice.at.value_or(Vec3::Zero()));
}

}  // namespace feltwire
