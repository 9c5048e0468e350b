#pragma once
// The simulated hands of --demo: programs feltwire-client that this server starts and ends.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

struct DemoHandsSetup {
  std::filesystem::path client;                // the program feltwire-client
  std::string server;                          // HOST:PORT of the control port from this machine
  std::string fingerprint;                     // of the server's certificate
  std::filesystem::path token;                 // file with a token that opens the scenes
  std::filesystem::path logs;                  // folder for what the hands say
  std::vector<std::string> scenes = {};        // their names
  std::chrono::milliseconds patience{10'000};  // of end(), before a hand is killed
};

struct DemoHand;

/// Owns two hands in each scene. One draws an eight on the surface at the scene's start, with a
/// local model of it; one taps on it, and feels the replies alone. An admin may change their laws.
/// A hand that ends is not started again. Hands get no file or socket of this process. They end if
/// the thread that made this object does, however it ends.
class DemoHands {
 public:
  DemoHands() = default;
  /// Starts the hands. Throws std::runtime_error if the program cannot be started.
  explicit DemoHands(const DemoHandsSetup& setup);
  ~DemoHands() { end(); }
  DemoHands(const DemoHands&) = delete;
  DemoHands& operator=(const DemoHands&) = delete;

  /// Returns a line for each hand that has ended since the last call, in words for the log.
  std::vector<std::string> ended();

  /// Tells the hands to end, also stopped ones, and waits until they have left. A hand that stays
  /// for longer than the patience is killed. May be called again.
  void end() noexcept;

 private:
  struct Hand {
    pid_t process = 0;
    std::string what;  // "left-hand of scene room"
    std::filesystem::path log;
  };
  void start(const DemoHandsSetup& setup, const std::string& scene, const DemoHand& demo);
  std::vector<Hand> hands_;
  std::chrono::milliseconds patience_{0};
};

}  // namespace feltwire
