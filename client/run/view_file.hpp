#pragma once
// The views of an observer, as a CSV file that stays readable after every end of the run.

#include <filesystem>

#include "client/run/observed_scene.hpp"
#include "client/servo/servo_loop.hpp"
#include "core/base/line_file.hpp"

namespace feltwire {

/// Rows t,kind,id,x,y,z,qw,qx,qy,qz,fx,fy,fz: of a hand (id: its number) with the force on it, of a
/// body (id: its object) without; of the robot's tool (id: the state) with the force on it, where
/// it is sensed, and of its target (id: the hand that leads, 0: none) without. hand_gone, body_gone
/// and robot_gone have no more than their id. The robot on the second seat is robot2, with
/// robot2_target and robot2_gone, and so on.
class ViewFile {
 public:
  /// Creates or replaces the file and writes the header. Throws std::runtime_error that names the
  /// file and the reason, as write() does.
  explicit ViewFile(const std::filesystem::path& file);

  /// Adds the rows of a view, and of the hands and bodies that `scene`, which has taken the view,
  /// no longer has.
  void add(const TimedView& shown, const ObservedScene& scene);
  void write() { file_.put(); }
  void finish() { file_.finish(); }

 private:
  LineFile file_;
};

}  // namespace feltwire
