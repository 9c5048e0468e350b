#pragma once
// Fetches what a client may have of a scene in full, while the servo loop runs.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/transport/background_work.hpp"
#include "client/transport/contact_cost.hpp"
#include "client/transport/control_client.hpp"
#include "core/base/ring.hpp"
#include "core/local_model/prefetched_geometry.hpp"

namespace feltwire {

/// The scene that a loop is in.
struct ScenePlace {
  std::uint64_t session = 0;
  std::uint32_t reloads = 0;  // Reply::reloads of the newest reply
  bool operator==(const ScenePlace&) const = default;
};

struct SceneFetchOptions {
  double servo_period = 1e-3;                                   // T [s]
  std::chrono::milliseconds timeout = std::chrono::seconds(5);  // of each answer
  ComputingClock clock = computing_time;
};

/// For one thread other than the servo's. Questions are asked in a thread of their own, so that
/// look() never blocks. First the surfaces or solids go to the servo, then the server is told that
/// the client has them: so no model counts on what is not there. What cannot be fetched, or has no
/// room (fetch_room.hpp), stays patches, or planes, of the local model. So does a scene whose
/// contact takes more than its share of a tick here (contact_cost()).
class SceneFetch {
 public:
  using Clock = std::chrono::steady_clock;
  /// The most scenes that are held at once: the one in use, and the one that the servo is to use
  /// next. No other is fetched before in_use() has named the newest.
  static constexpr std::size_t kMostKept = 2;

  /// Fetched scenes go to the servo through `out`. Each lives as long as this object, or until
  /// in_use() names a newer one.
  SceneFetch(ServerAccess server, Ring<const FetchedScene*>& out, SceneFetchOptions options = {});

  /// Call it now and then, with the present place of the loop; session 0: nothing is fetched.
  void look(const ScenePlace& place, Clock::time_point now) noexcept;
  /// The session is at this server from now on.
  void put_server(const ServerAccess& server) { server_ = server; }
  /// Tells which scene the servo uses; null: none. This frees all older ones.
  void in_use(const FetchedScene* fetched) noexcept;

  /// Why the server's scene was not taken, in one line: it sent what cannot be, or the contact with
  /// it takes too long here. Then it is asked again only after the place has changed. Empty: it was
  /// taken, or nothing was wrong with it.
  const std::string& refusal() const { return refusal_; }

  /// Whether a question is asked whose outcome look() has not taken yet.
  bool asking() const { return attempt_.valid(); }
  /// How many objects the server sends no more patches or planes of.
  std::size_t known() const { return known_; }

 private:
  using Fetched = std::shared_ptr<const FetchedScene>;
  struct Attempt {
    Fetched fetched{};      // a new one; null: the session has taken that
    std::size_t known = 0;  // objects that it has taken
    bool failed = false;    // the next attempt may succeed
    std::string refusal{};  // why the server's scene is of no use; empty: it is
  };
  struct Question {
    ServerAccess server;
    std::uint64_t session = 0;
    Fetched have;       // that the servo has; null: nothing
    bool full = false;  // there is no room for another
    SceneFetchOptions options;
  };
  static Attempt attempt(const Question& question);
  void hand_over(Fetched fetched) noexcept;
  void begin(const ScenePlace& place);
  void put_off(Clock::time_point now) noexcept;
  Attempt outcome() noexcept;

  ServerAccess server_;
  Ring<const FetchedScene*>& out_;
  SceneFetchOptions options_;
  BackgroundWork<Attempt> attempt_;
  std::vector<Fetched> kept_;     // the newest last
  std::uint64_t of_session_ = 0;  // in which that was fetched
  ScenePlace asked_for_, settled_;
  Clock::time_point next_{};  // for the next attempt
  std::chrono::milliseconds wait_;
  std::size_t known_ = 0;
  std::string refusal_;
  bool unsettled_ = false;  // the server has not said that the newest scene is the present one
};

}  // namespace feltwire
