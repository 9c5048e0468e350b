#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/base/time.hpp"
#include "protocol/session/role.hpp"
#include "protocol/wire/control.hpp"
#include "server/fleet/directory.hpp"
#include "server/fleet/ownership.hpp"
#include "server/fleet/scene_record.hpp"
#include "server/fleet/signing_keys.hpp"
#include "server/fleet/ticket.hpp"

namespace feltwire {

inline constexpr Nanoseconds kBeat = std::chrono::seconds(2);  // between two heartbeats
inline constexpr Nanoseconds kSilent = 3 * kBeat;              // a host without a heartbeat
inline constexpr Nanoseconds kProbeAgain = std::chrono::milliseconds(500);

/// A scene that the host has loaded, and could serve.
struct LoadedFleetScene {
  std::string name;
  SceneDigest digest{};
};

/// The knowledge of one host about its fleet: the other hosts, the owners of all scenes, and the
/// scenes that it serves itself. It answers joins from memory. It makes no call, and time is an
/// argument; HostAgent carries out what it decides. All functions may be called by any thread.
class FleetMember {
 public:
  /// `about`: the heartbeat of this host, without what changes. `scenes`: that it has loaded.
  FleetMember(HostRecord about, const std::vector<LoadedFleetScene>& scenes,
              const SigningKeys& keys);

  // ---- Joins ----

  struct Join {
    std::string_view scene;
    std::string client;  // its name of the token
    Role role = Role::observer;
    Epoch seen;               // that the client says it has seen
    std::string_view ticket;  // empty: it has none
    bool follows_redirects = false;
    bool ipv6 = false;  // the client has connected to an IPv6 address
  };
  /// This host serves the scene.
  struct Seat {
    Epoch epoch;
    std::vector<control::FleetHost> hosts;  // to ask if this one is silent
  };
  using Answer = std::variant<Seat, control::Redirected, control::Refused>;
  /// Empty: no host serves a scene of that name.
  std::optional<Answer> answer(const Join& join, Nanoseconds now, std::chrono::sys_seconds date);
  /// The host that serves the scene, for people; empty: this one, or nobody knows.
  std::optional<std::string> elsewhere(std::string_view scene) const;

  // ---- What the directory delivers ----

  void see(Bucket bucket, const DirectoryEntry& entry, Nanoseconds now);
  /// All entries of the scenes have been seen once, so a scene without an owner may be claimed.
  void listed();
  /// A heartbeat of this host was acknowledged.
  void heard(Nanoseconds now);

  // ---- What the agent does ----

  struct Load {
    std::uint32_t hands = 0;
    std::vector<std::uint8_t> free_shares;  // as in HostRecord
  };
  HostRecord heartbeat(const Load& load);

  /// A record to write by compare-and-swap.
  struct Write {
    std::string scene;
    SceneRecord record;
    std::uint64_t revision = 0;
    bool claims = false;
  };
  std::vector<Write> writes(Nanoseconds now, std::uint64_t random);
  void finish(const Write& write, const WriteAnswer& answer);

  /// An owner, or a standby, that seems to be gone, to be asked whether it is.
  struct Suspect {
    HostName host;
    std::string address;
    std::uint16_t port = 0;
    Fingerprint fingerprint{};
  };
  std::optional<Suspect> suspect(Nanoseconds now);
  /// Returns the scenes that this host serves from now on, because their owner is gone.
  std::vector<std::string> probed(const HostName& host, bool answers);

  /// As of SigningKeys: the next key of tickets, and its turn to sign.
  void announce(const paseto::SigningKey& next);
  void change_key();

  /// The scenes that this host has lost to another since the last call.
  std::vector<std::string> take_lost();
  /// The scenes that it serves now.
  std::vector<std::string> served() const;
  const HostName& self() const { return about_.host; }

 private:
  struct KnownHost {
    HostRecord record;
    Nanoseconds heard{0};
  };
  struct KnownScene {
    SceneOwnership ownership;
    std::optional<SceneDigest> loaded;  // the digest of this host's files; empty: it has none
    bool wanted = false;                // a client asked for it, and this host may take it over
  };
  using Scenes = std::map<std::string, KnownScene, std::less<>>;

  void see_host(const DirectoryEntry& entry, Nanoseconds now);
  void see_scene(const DirectoryEntry& entry);
  const KnownHost* find(const HostName& host) const;
  bool silent(const HostName& host, Nanoseconds now) const;
  bool gone(const HostName& host) const;
  bool may_take(const KnownScene& scene, Nanoseconds now) const;
  std::optional<control::FleetHost> address_of(const HostName& host, bool ipv6) const;
  std::vector<control::FleetHost> others(const SceneRecord& record, bool ipv6) const;
  std::optional<control::Refused> check_ticket(KnownScene& scene, const Join& join,
                                               std::chrono::sys_seconds date);
  Answer redirect(const KnownScene& scene, const Join& join, std::chrono::sys_seconds date) const;
  HostName choose_standby(const std::string& name, const KnownScene& scene, Nanoseconds now,
                          std::uint64_t random) const;

  mutable std::mutex mutex_;
  HostRecord about_;
  SigningKeys keys_;
  TicketKeys ticket_keys_;
  TicketGate gate_;
  std::map<std::string, KnownHost> hosts_;  // by name, without this one
  Scenes scenes_;
  std::map<HostNumber, Nanoseconds> asked_;  // when a suspect was asked last
  // Processes that have ended, with the number of their last heartbeat. A later one shows that a
  // process lives after all.
  std::map<HostNumber, std::uint64_t> gone_;
  std::vector<std::string> lost_;
  Nanoseconds began_{-1}, heard_{-1};
  bool listed_ = false;
};

}  // namespace feltwire
