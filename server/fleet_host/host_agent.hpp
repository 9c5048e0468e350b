#pragma once

#include <array>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/fleet/directory.hpp"
#include "server/fleet_host/fleet_member.hpp"
#include "server/fleet_host/fleet_tokens.hpp"

namespace feltwire {

/// The questions and news of an agent for its server. It calls them on its own thread.
struct AgentCallbacks {
  std::function<FleetMember::Load()> load;
  /// Other hosts serve these scenes now: their sessions here must end.
  std::function<void(std::vector<std::string> scenes)> lost;
  /// The file of the fleet's tokens has changed.
  std::function<void()> tokens = [] {};
};

/// The files of an agent; empty: it has none, and does not do the thing.
struct AgentFiles {
  std::filesystem::path keys;    // of ticket_keys(), for their change
  std::filesystem::path tokens;  // of FleetTokens
};

/// The thread of a host that talks to the directory of its fleet: it announces the host, watches,
/// claims scenes, names standbys, takes over the scenes of hosts that are gone, hands scenes over
/// and takes what is handed over to this host, changes the keys of tickets, and keeps the file of
/// the fleet's tokens. No session and no join waits for it. While the directory does not answer it
/// tries again and again, and scenes are still taken over.
class HostAgent {
 public:
  /// Throws FileError if the file of the tokens cannot be used.
  HostAgent(std::shared_ptr<Directory> directory, FleetMember& member, AgentCallbacks callbacks,
            const AgentFiles& files = {});
  /// stop().
  ~HostAgent();
  HostAgent(const HostAgent&) = delete;
  HostAgent& operator=(const HostAgent&) = delete;

  /// Starts the thread. Call it once.
  void start();
  /// Hands all scenes over, takes no others, and returns when other hosts serve them, when no host
  /// takes those that are left, or after `patience`. From another thread, between start() and
  /// stop().
  void drain(Nanoseconds patience);
  /// Waits for the thread, which may wait for an answer of the directory. May be called again.
  void stop();

 private:
  void watch(Nanoseconds now);
  void run();
  void look(Nanoseconds now);
  void beat(Nanoseconds now);
  void read(Bucket bucket);
  void see(Bucket bucket, const DirectoryEntry& entry);
  void see_all(Bucket bucket, const std::vector<DirectoryEntry>& entries);
  void list(Nanoseconds now);
  void write_tokens(const std::vector<DirectoryEntry>& listed);
  void save_tokens(Nanoseconds now);
  void write(Nanoseconds now);
  void ask_suspects();
  void hand_over();
  void change_keys(Nanoseconds now);
  bool ended();

  std::shared_ptr<Directory> directory_;
  FleetMember& member_;
  AgentCallbacks callbacks_;
  std::filesystem::path keys_;
  std::unique_ptr<FleetTokens> tokens_;  // null: the fleet's tokens do not count here
  std::array<std::unique_ptr<DirectoryWatch>, kBucketCount> watches_;  // by Bucket
  Nanoseconds delivered_{0};  // when the watch of the hosts delivered something
  Nanoseconds next_beat_{0}, next_list_{0}, next_write_{0}, next_key_{0}, next_save_{0};
  bool announced_ = false;  // the next key is known to the other hosts, and does not sign yet
  bool silent_ = false;     // the directory has not answered, and the log says so
  std::mutex mutex_;
  std::condition_variable woken_;
  bool stop_ = false;      // guarded by mutex_
  bool ends_ = false;      // guarded by mutex_: drain() was called
  bool drained_ = false;   // guarded by mutex_: since then, as FleetMember::drained()
  std::string kept_ = {};  // that the log has said
  std::thread thread_;
};

}  // namespace feltwire
