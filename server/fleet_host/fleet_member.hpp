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
#include "server/fleet/wish.hpp"
#include "server/fleet_host/known_hosts.hpp"

namespace feltwire {

inline constexpr Nanoseconds kProbeAgain = std::chrono::milliseconds(500);
/// The time that the host to which a scene is handed over has to take it. Then the former owner
/// takes the scene back, and tries again after the second time.
inline constexpr Nanoseconds kTakeTime = std::chrono::seconds(3);
inline constexpr Nanoseconds kHandOverAgain = std::chrono::seconds(10);
/// Scenes that are on their way to other hosts at a time.
inline constexpr std::size_t kHandOversAtOnce = 4;

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

  // ---- Handing over ----

  /// The host takes no further scene and hands its own over, as after the wish to drain. `ends`: it
  /// is about to end, and no wish changes that.
  void drain(bool ends);
  /// A scene that is to go to another host, once that has answered.
  struct HandOver {
    std::string scene;
    Suspect target;
  };
  std::vector<HandOver> hand_overs(Nanoseconds now, std::uint64_t random);
  /// The target was asked. Returns whether the scene is handed over to it.
  bool hand_over(const HandOver& asked, bool answers, Nanoseconds now);
  /// Returns the scenes that this host serves from now on, because their owners have handed them
  /// over to it.
  std::vector<std::string> take_handed();
  /// Whether the host has answered a wish since the last call: its heartbeat says so.
  bool take_news();
  /// Whether a host that drains can do no more: it has no scene, or none that another host takes.
  bool drained() const;

  /// As of SigningKeys: the next key of tickets, and its turn to sign.
  void announce(const paseto::SigningKey& next);
  void change_key();

  /// The scenes that this host has lost to another since the last call.
  std::vector<std::string> take_lost();
  /// The scenes that it serves now.
  std::vector<std::string> served() const;
  const HostName& self() const { return about_.host; }

 private:
  struct KnownScene {
    SceneOwnership ownership;
    std::optional<SceneDigest> loaded;  // the digest of this host's files; empty: it has none
    bool wanted = false;                // a client asked for it, and this host may take it over
    HostName move_to;                   // that a wish names; number 0: none
    Nanoseconds take_until{0};          // a scene that was handed over: then it is taken back
    Nanoseconds hand_over_from{0};      // not before, as it was taken back
    std::string kept;                   // why it is not handed over, for people; empty: nothing
  };
  using Scenes = std::map<std::string, KnownScene, std::less<>>;

  void see_host(const DirectoryEntry& entry, Nanoseconds now);
  void see_scene(const DirectoryEntry& entry);
  void see_wish(const DirectoryEntry& entry, Nanoseconds now);
  std::string carry_out(const Wish& wish, Nanoseconds now);
  std::string kept() const;
  void set_draining(bool draining);
  void take_back(KnownScene& scene, Nanoseconds now);
  HostName target_of(const std::string& name, KnownScene& scene, Nanoseconds now,
                     std::uint64_t random) const;
  void name_standby(const std::string& name, KnownScene& scene, Nanoseconds now,
                    std::uint64_t random);
  bool may_claim(const KnownScene& scene, Nanoseconds now) const;
  bool may_take(const KnownScene& scene, Nanoseconds now) const;
  std::optional<control::Refused> check_ticket(KnownScene& scene, const Join& join,
                                               std::chrono::sys_seconds date);
  Answer redirect(const KnownScene& scene, const Join& join, std::chrono::sys_seconds date) const;

  mutable std::mutex mutex_;
  HostRecord about_;
  SigningKeys keys_;
  TicketKeys ticket_keys_;
  TicketGate gate_;
  KnownHosts hosts_;
  Scenes scenes_;
  std::map<HostNumber, Nanoseconds> asked_;  // when a suspect was asked last
  std::vector<std::string> lost_;
  bool listed_ = false;
  bool ends_ = false;
  bool news_ = false;  // for take_news()
};

}  // namespace feltwire
