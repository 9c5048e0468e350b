#pragma once
// The simulated hands of --demo: programs feltwire-client that this server starts and ends.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace feltwire {

struct DemoHandsSetup {
  std::filesystem::path client;          // the program feltwire-client
  std::string server;                    // HOST:PORT of the control port from this machine
  std::string fingerprint;               // of the server's certificate
  std::filesystem::path token;           // file with a token that opens the scenes
  std::filesystem::path logs;            // folder for what the hands say
  std::vector<std::string> scenes = {};  // their names
};

/// Owns two hands in each scene. One draws an eight on the surface at the scene's start, and one
/// taps on it. An admin may change their laws. A hand that ends is not started again.
class DemoHands {
 public:
  DemoHands() = default;
  /// Starts the hands. Throws std::runtime_error if the program cannot be started.
  explicit DemoHands(const DemoHandsSetup& setup);
  ~DemoHands() { end(); }
  DemoHands(const DemoHands&) = delete;
  DemoHands& operator=(const DemoHands&) = delete;

  /// Tells the hands to end, and waits until they have left. May be called again.
  void end() noexcept;

 private:
  void start(const DemoHandsSetup& setup, const std::string& scene, const std::string& name,
             const std::string& device);
  std::vector<pid_t> hands_;
};

}  // namespace feltwire
