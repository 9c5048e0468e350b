#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.hpp"
#include "protocol/wire/control.hpp"
#include "server/fleet/scene_record.hpp"

namespace feltwire {

inline constexpr Nanoseconds kBeat = std::chrono::seconds(2);  // between two heartbeats
inline constexpr Nanoseconds kSilent = 3 * kBeat;              // a host without a heartbeat

/// The other hosts of a fleet, as one host knows them from their heartbeats. Time is an argument.
class KnownHosts {
 public:
  explicit KnownHosts(HostName self) : self_(std::move(self)) {}

  /// The directory has begun to answer. Only the first call counts.
  void begin(Nanoseconds now);
  /// A heartbeat of this host was acknowledged.
  void heard(Nanoseconds now);
  /// The directory delivers a heartbeat under this key. Returns false, and changes nothing, if it
  /// is this host's or no later one than those before.
  bool see(const std::string& key, const HostRecord& record, Nanoseconds now);
  /// The process has given no answer: it is gone until a later heartbeat of it comes.
  void lose(const HostName& host);

  /// Whether the directory has acknowledged a heartbeat of this host lately.
  bool directory_answers(Nanoseconds now) const;
  /// Null: no heartbeat of this process is known.
  const HostRecord* find(const HostName& host) const;
  /// Whether the process has ended for certain.
  bool gone(const HostName& host) const;
  /// Whether no heartbeat of it has come for some time. Nothing is known about it while the
  /// directory itself is silent.
  bool silent(const HostName& host, Nanoseconds now) const;
  /// Why the host cannot serve this scene (scene_tag()), for people; empty: it can.
  std::optional<std::string> unfit(const HostName& host, std::uint64_t scene,
                                   Nanoseconds now) const;

  /// The address where clients reach it; empty: unknown.
  std::optional<control::FleetHost> address_of(const HostName& host, bool ipv6) const;
  /// The hosts to ask if this one is silent: the standby, then any others.
  std::vector<control::FleetHost> others(const SceneRecord& record, bool ipv6) const;
  /// Returns a host that can serve the scene: of two that are drawn at random, the one with more
  /// room, in another rack than `rack` if there is one. Number 0: there is none.
  HostName choose(std::uint64_t scene, std::string_view rack, Nanoseconds now,
                  std::uint64_t random) const;

 private:
  struct Known {
    HostRecord record;
    Nanoseconds heard{0};
  };

  HostName self_;
  std::map<std::string, Known> hosts_;  // by name
  // Processes that have ended, with the number of their last heartbeat. A later one shows that a
  // process lives after all.
  std::map<HostNumber, std::uint64_t> gone_;
  Nanoseconds began_{-1}, heard_{-1};
};

}  // namespace feltwire
