#pragma once
// A session that observes a scene, and its thread.

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "client/servo/servo_thread.hpp"
#include "client/transport/fleet_route.hpp"

namespace feltwire {

/// How an observer joins its scene.
struct ObserverRequest {
  std::string name;                         // of the program, for the server's log
  std::string scene;                        // name of the scene
  double period = 0.01;                     // [s] between two samples; each is answered by a view
  std::chrono::milliseconds timeout{1000};  // of the join, in each of its steps
};

/// A session of the role observer. Its thread takes a view of the scene for each sample. It gives
/// no force and asks for no real time.
class ObserverSession {
 public:
  /// Joins the scene and starts the thread. Blocks, and throws as join() does. `route` learns from
  /// the join; an observer that joins again uses the same.
  ObserverSession(FleetRoute& route, const ObserverRequest& request);
  /// Leaves the scene.
  ~ObserverSession();
  ObserverSession(const ObserverSession&) = delete;
  ObserverSession& operator=(const ObserverSession&) = delete;

  /// The next view; false: there is none. The room is for 64 views; newer ones are lost.
  bool take(TimedView& view) noexcept;
  /// Whether the session has ended.
  bool over() const noexcept { return thread_->over(); }
  /// Readable then; use it only to wait.
  int over_descriptor() const noexcept { return thread_->over_descriptor(); }
  /// Leaves the scene, waits for the thread, and says for people why the session ended.
  std::string end();

 private:
  struct Task;

  std::shared_ptr<Task> task_;
  std::optional<ServoThread> thread_;
};

}  // namespace feltwire
