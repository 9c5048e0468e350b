#pragma once
// Viewers of the live page: they read every picture and draw nothing.

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace feltwire::netbench {

/// Each is a process of its own. They run only when nobody else wants their core, since people draw
/// on other machines.
class Viewers {
 public:
  /// Starts them, and waits until each has a picture. `port`: of the page, on 127.0.0.1. Throws
  /// std::runtime_error. Only while this process has one thread.
  Viewers(int count, std::uint16_t port, const std::string& token, int core);
  /// Ends them.
  ~Viewers();
  Viewers(const Viewers&) = delete;
  Viewers& operator=(const Viewers&) = delete;

  /// The number of pictures that all of them have read so far.
  std::uint64_t pictures() const { return pictures_->load(); }

 private:
  std::vector<pid_t> processes_;
  std::atomic<std::uint64_t>* pictures_;  // memory that the processes share
};

}  // namespace feltwire::netbench
