#pragma once
// Fetches the surfaces of a scene that a client may have in full, while the servo loop runs.

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
/// look() never blocks. First the surfaces go to the servo, then the server is told that it has
/// them: so no model counts on a surface that is not there. Surfaces that cannot be fetched stay
/// patches of the local model.
class SurfaceFetch {
 public:
  using Clock = std::chrono::steady_clock;
  /// Larger surfaces stay on the server: a client in a scanned city would fetch for minutes.
  static constexpr std::uint32_t kMostTriangles = 200'000;  // of all surfaces together

  /// Surfaces for the servo go to `out`; they live as long as this, or until in_use() names a newer
  /// one.
  SurfaceFetch(ServerAccess server, Ring<const WholeSurfaces*>& out,
               std::chrono::milliseconds timeout = std::chrono::seconds(5));

  /// Call it now and then, with the present place of the loop; session 0: nothing is fetched.
  void look(const ScenePlace& place, Clock::time_point now) noexcept;
  /// The surfaces that the servo has taken; null: none. Older ones are freed.
  void in_use(const WholeSurfaces* surfaces) noexcept;

  /// Whether a question is asked whose outcome look() has not taken yet.
  bool asking() const { return attempt_.valid(); }
  /// How many objects the server renders no more patches of.
  std::size_t known() const { return known_; }

 private:
  struct Attempt {
    std::shared_ptr<const WholeSurfaces> surfaces{};  // new ones; null: the session has taken those
    std::size_t known = 0;                            // objects that it has taken
    bool failed = false;                              // the next attempt may succeed
  };
  struct Question {
    ServerAccess server;
    std::uint64_t session = 0;
    std::shared_ptr<const WholeSurfaces> have;  // that the servo has; null: none
    std::chrono::milliseconds timeout;
  };
  static Attempt attempt(const Question& question);
  void hand_over(std::shared_ptr<const WholeSurfaces> surfaces) noexcept;
  void begin(const ScenePlace& place);
  Attempt outcome() noexcept;

  ServerAccess server_;
  Ring<const WholeSurfaces*>& out_;
  std::chrono::milliseconds timeout_;
  std::future<Attempt> attempt_;
  std::vector<std::shared_ptr<const WholeSurfaces>> kept_;  // the newest last
  std::uint64_t of_session_ = 0;                            // in which that was fetched
  ScenePlace asked_for_, settled_;
  Clock::time_point next_{};  // for the next attempt
  std::chrono::milliseconds wait_;
  std::size_t known_ = 0;
};

}  // namespace feltwire
