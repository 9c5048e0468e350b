#include "client/run/view_file.hpp"

namespace feltwire {
namespace {

/// Returns the kind of a robot in the file: "robot", "robot2", ...
std::string robot_kind(std::uint8_t seat) {
  return seat == 0 ? "robot" : "robot" + std::to_string(seat + 1);
}

void begin_row(std::string& lines, double time, const std::string& kind, std::uint32_t id) {
  append(lines, time);
  lines += ',';
  lines += kind;
  lines += ',' + std::to_string(id);
}

void append_vector(std::string& lines, const Vec3& v) {
  for (int i = 0; i < 3; ++i) {
    lines += ',';
    append(lines, v[i]);
  }
}

void append_pose(std::string& lines, const Pose& pose) {
  append_vector(lines, pose.position);
  lines += ',';
  append(lines, pose.orientation.w());
  append_vector(lines, pose.orientation.vec());
}

}  // namespace

ViewFile::ViewFile(const std::filesystem::path& file)
    : file_(file, "the view", "--view", "t,kind,id,x,y,z,qw,qx,qy,qz,fx,fy,fz\n") {}

void ViewFile::add(const TimedView& shown, const ObservedScene& scene) {
  std::string& lines = file_.lines();
  for (const SeenHand& hand : shown.view.hands()) {
    begin_row(lines, shown.time, "hand", hand.number);
    append_pose(lines, hand.pose);
    append_vector(lines, hand.force);
    lines += '\n';
  }
  for (const SeenBody& body : shown.view.bodies()) {
    begin_row(lines, shown.time, "body", body.object);
    append_pose(lines, body.pose);
    lines += ",,,\n";
  }
  if (const auto& robot = shown.view.robot) {
    const std::string kind = robot_kind(robot->seat);
    begin_row(lines, shown.time, kind, static_cast<std::uint32_t>(robot->state));
    append_pose(lines, robot->pose);
    if (robot->force)
      append_vector(lines, *robot->force);
    else
      lines += ",,,";
    lines += '\n';
    begin_row(lines, shown.time, kind + "_target", robot->hand);
    append_pose(lines, robot->target);
    lines += ",,,\n";
  }
  constexpr const char* kNothing = ",,,,,,,,,,\n";
  for (const std::uint32_t number : scene.hands_gone()) {
    begin_row(lines, shown.time, "hand_gone", number);
    lines += kNothing;
  }
  for (const std::uint16_t object : scene.bodies_gone()) {
    begin_row(lines, shown.time, "body_gone", object);
    lines += kNothing;
  }
  for (const std::uint8_t seat : scene.robots_gone()) {
    begin_row(lines, shown.time, robot_kind(seat) + "_gone", 0);
    lines += kNothing;
  }
}

}  // namespace feltwire
