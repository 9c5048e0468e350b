#pragma once
// Viewers of the live page: they read every picture and draw nothing.

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace feltwire::netbench {

/// Each viewer is a separate process. It runs only when its core is otherwise idle, because real
/// viewers draw on other machines.
class Viewers {
 public:
  /// Starts the viewers and waits until each has a picture. `port`: the page's, on 127.0.0.1.
  /// Throws std::runtime_error. The calling process must have a single thread.
  Viewers(int count, std::uint16_t port, const std::string& token, int core);
  /// Ends the viewers.
  ~Viewers();
  Viewers(const Viewers&) = delete;
  Viewers& operator=(const Viewers&) = delete;

  /// The number of pictures that all viewers together have read so far.
  std::uint64_t pictures() const { return pictures_->load(); }

 private:
  std::vector<pid_t> processes_;
  std::atomic<std::uint64_t>* pictures_;  // memory that the processes share
};

}  // namespace feltwire::netbench
