#pragma once
// The servo loop in a thread of its own, and another thread that watches it.

#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>

#include "client/device/guarded_device.hpp"
#include "client/servo/servo_loop.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire {

/// The data of a servo loop. The threads share it: a thread that never returns from its device
/// keeps it alive.
struct ServoTask {
  ServoTask(std::unique_ptr<Device> hand, std::shared_ptr<Transport> way,
            const SessionParameters& parameters, const ServoOptions& servo_options)
      : device(std::move(hand)),
        guard(*device),
        transport(std::move(way)),
        servo(device->spec(), parameters, for_device(servo_options, *device)) {}

  static ServoOptions for_device(ServoOptions options, const Device& device) {
    options.motion_scale = device.motion_scale();
    return options;
  }

  std::unique_ptr<Device> device;
  GuardedDevice guard;
  std::shared_ptr<Transport> transport;
  Servo servo;
  LoopOptions options;
  LoopOutputs outputs;
  /// The priority for request_real_time(). kNoRealTime: none is requested, for a process in which
  /// other threads have priority.
  static constexpr int kNoRealTime = -1;
  int priority = 0;
  double let_go_after = 0.0;  // [s] as let_go_time() takes it
  LoopResult result;
};

/// Runs the loop of a task. If it makes no tick for let_go_time() while a force is on the hand
/// (StallDetector), a second thread releases the device, and the run has failed. That thread needs
/// nothing of the first one, which may be in a computation or in a call of the device.
class ServoThread {
 public:
  /// Throws std::system_error or std::bad_alloc if the system gives no threads or descriptors: then
  /// the device got no command.
  explicit ServoThread(std::shared_ptr<ServoTask> task);
  /// Calls end().
  ~ServoThread();
  ServoThread(const ServoThread&) = delete;
  ServoThread& operator=(const ServoThread&) = delete;

  /// Waits until the thread has requested real time.
  RealTime real_time() const noexcept;
  /// Asks the loop to release the hand and end. Does not wait.
  void stop() noexcept;
  /// Whether the loop is over, or was abandoned.
  bool over() const noexcept;
  /// Readable then; use it only to wait.
  int over_descriptor() const noexcept;
  /// Calls stop(), and waits. Afterwards the device is released, and the task's result and
  /// statistics may be read. False if the thread stands still for good and was abandoned: the
  /// program should end at once.
  bool end() noexcept;

 private:
  struct Shared;
  static void run_loop(Shared& shared) noexcept;
  static void watch(Shared& shared) noexcept;

  std::shared_ptr<Shared> shared_;
  std::thread watch_, servo_;
};

}  // namespace feltwire
