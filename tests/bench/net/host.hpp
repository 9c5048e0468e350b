#pragma once
// A server or an echo in a separate process on its own core, so that its CPU time is measured apart
// from the load's.

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/crypto/aead.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire::netbench {

enum class HostKind {
  echo_blocking,
  echo_waiting,
  echo_spinning,
  ours_sleeping,
  ours_bounded,
  ours_spinning,
  ours_real_time  // sleeps
};
const char* name(HostKind kind);
constexpr bool ours(HostKind kind) { return kind >= HostKind::ours_sleeping; }

struct HostOptions {
  HostKind kind = HostKind::ours_sleeping;
  std::string scene_file;
  int clients = 1;               // of each scene
  std::vector<int> cores = {0};  // one scene on each core
  int redundancy = 0;
  CipherSuite suite = preferred_suite();
  int page_core = -1;  // for the live page of these scenes; negative: no page
  std::string record;  // FILE.mcap for the first scene's inputs; empty: none
  int recorder_core = 0;
};

/// The result of a recording.
struct Recorded {
  std::uint64_t lost = 0;   // events lost because the ring was full
  std::uint64_t bytes = 0;  // of the file
};

/// A scene as the load sees it.
struct Target {
  std::uint16_t port = 0;
  std::vector<std::uint64_t> sessions;  // one for each client, all joined
};

/// The join request of every client.
control::JoinRequest join_request(int redundancy);

/// The keys of a session; fixed, so that both processes know them.
SessionKeys session_keys(std::uint64_t session, CipherSuite suite);

class HostProcess {
 public:
  /// Starts the process and makes all clients join. Throws std::runtime_error. The calling process
  /// must have a single thread.
  explicit HostProcess(const HostOptions& options);
  /// Ends the process.
  ~HostProcess();
  HostProcess(const HostProcess&) = delete;
  HostProcess& operator=(const HostProcess&) = delete;

  const std::vector<Target>& targets() const { return targets_; }
  pid_t process() const { return process_; }
  /// Ends the recording, so that the file is complete, and the process. Call it once, only for a
  /// process that records. Throws std::runtime_error.
  Recorded finish();
  /// The port of the live page; 0 if there is none.
  std::uint16_t page_port() const { return page_port_; }
  /// A token for the page's viewers.
  const std::string& viewers_token() const { return viewers_token_; }

 private:
  pid_t process_ = -1;
  int pipe_ = -1;
  std::string record_;
  std::vector<Target> targets_;
  std::uint16_t page_port_ = 0;
  std::string viewers_token_;
};

}  // namespace feltwire::netbench
