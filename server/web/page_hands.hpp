#pragma once
// Hands that viewers of the live page hold. Only what the page needs to know: the rooms of the
// server use nothing of the client's, and such a hand is a client.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/types.hpp"
#include "protocol/crypto/secret.hpp"
#include "protocol/crypto/tls.hpp"

namespace feltwire::web {

/// One hand, of one viewer. Called on the page's thread; no call waits or throws, but for want of
/// memory.
class PageHand {
 public:
  enum class State : std::uint8_t { joining, held, released };
  struct Status {
    State state = State::joining;
    std::uint64_t session = 0;  // of held
    Vec3 start = Vec3::Zero();  // [m] where it began, world frame; of held
    double stiffness = 0.0;     // [N/m] of the spring from the hand to its target; of held
    double reach = 0.0;         // [m] over which it grows: it pulls no harder farther away; of held
    std::string reason = {};    // of released: why, for people
  };

  virtual ~PageHand() = default;
  virtual Status status() const = 0;
  /// Where it shall be [m], world frame. It goes there at a limited speed. To be said again and
  /// again: a hand that is told nothing for a second lets go.
  virtual void point(const Vec3& target) noexcept = 0;
  /// The force fades, then the session ends.
  virtual void release() noexcept = 0;
};

struct PageHandRequest {
  std::string scene;
  std::string client;  // the name that others see
  Secret token;
};

class PageHands {
 public:
  /// Releases all hands and waits until their sessions have ended.
  virtual ~PageHands() = default;
  /// A hand that joins the scene as pointer, in threads of its own. Returns at once; null where all
  /// hands are held.
  virtual std::shared_ptr<PageHand> take(const PageHandRequest& request) = 0;
};

/// The settings of all page hands.
struct PageHandsSetup {
  std::string host;  // where the server's control port is reached from this machine
  std::uint16_t port = 0;
  Fingerprint fingerprint;  // of its certificate
  std::size_t most = 0;     // hands at once
};
using MakePageHands = std::function<std::unique_ptr<PageHands>(const PageHandsSetup& setup)>;

}  // namespace feltwire::web
