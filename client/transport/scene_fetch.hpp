#pragma once
// Fetches what a client may have of a scene in full, while the servo loop runs.

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <vector>

#include "client/transport/control_client.hpp"
#include "core/base/ring.hpp"
#include "core/local_model/whole_surfaces.hpp"

namespace feltwire {

/// The scene that a loop is in.
struct ScenePlace {
  std::uint64_t session = 0;
  std::uint32_t reloads = 0;  // Reply::reloads of the newest reply
  bool operator==(const ScenePlace&) const = default;
};

/// For one thread other than the servo's. Questions are asked in a thread of their own, so that
/// look() never blocks. First the surfaces or solids go to the servo, then the server is told that
/// the client has them: so no model counts on what is not there. What cannot be fetched stays
/// patches, or planes, of the local model.
class SceneFetch {
 public:
  using Clock = std::chrono::steady_clock;
  /// Larger surfaces stay on the server: a client in a scanned city would fetch for minutes.
  static constexpr std::uint32_t kMostTriangles = 200'000;  // of all surfaces together

  /// Fetched scenes go to the servo through `out`. Each lives as long as this object, or until
  /// in_use() names a newer one.
  SceneFetch(ServerAccess server, Ring<const FetchedScene*>& out,
             std::chrono::milliseconds timeout = std::chrono::seconds(5));

  /// Call it now and then, with the present place of the loop; session 0: nothing is fetched.
  void look(const ScenePlace& place, Clock::time_point now) noexcept;
  /// Tells which scene the servo uses; null: none. This frees all older ones.
  void in_use(const FetchedScene* fetched) noexcept;

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
  };
  struct Question {
    ServerAccess server;
    std::uint64_t session = 0;
    Fetched have;  // that the servo has; null: nothing
    std::chrono::milliseconds timeout;
  };
  static Attempt attempt(const Question& question);
  void hand_over(Fetched fetched) noexcept;
  void begin(const ScenePlace& place);
  Attempt outcome() noexcept;

  ServerAccess server_;
  Ring<const FetchedScene*>& out_;
  std::chrono::milliseconds timeout_;
  std::future<Attempt> attempt_;
  std::vector<Fetched> kept_;     // the newest last
  std::uint64_t of_session_ = 0;  // in which that was fetched
  ScenePlace asked_for_, settled_;
  Clock::time_point next_{};  // for the next attempt
  std::chrono::milliseconds wait_;
  std::size_t known_ = 0;
};

}  // namespace feltwire
