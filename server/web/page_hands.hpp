#pragma once
// Hands that viewers of the live page hold. This is only the interface for the page: the server's
// rooms use nothing of the client's, and such a hand is a client.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/base/types.hpp"
#include "protocol/crypto/secret.hpp"
#include "protocol/crypto/tls.hpp"

namespace feltwire::web {

/// A hand of a viewer. Called on the page's thread; no call waits, and a call throws only if
/// there is no memory.
class PageHand {
 public:
  enum class State : std::uint8_t { joining, held, released };
  struct Status {
    State state = State::joining;
    std::uint64_t session = 0;  // for held
    Vec3 start = Vec3::Zero();  // [m] its start, world frame; for held
    double stiffness = 0.0;     // [N/m] of the spring from the hand to its target; for held
    double reach = 0.0;         // [m] the largest length of that spring; for held
    std::string reason = {};    // for released: the reason, for people
  };

  virtual ~PageHand() = default;
  virtual Status status() const = 0;
  /// Sets its target [m], world frame. It goes there at a limited speed. Repeat the call: a hand
  /// without a call for a second is released.
  virtual void point(const Vec3& target) noexcept = 0;
  /// The force fades, then the session ends.
  virtual void release() noexcept = 0;
};

struct PageHandRequest {
  std::string scene;
  std::string client;  // its name for others
  Secret token;
  std::string mode = {};  // its bounding method; empty: the usual one
};

class PageHands {
 public:
  /// Releases all hands and waits until their sessions have ended.
  virtual ~PageHands() = default;
  /// A hand that joins the scene as pointer, in threads of its own. Returns at once; null if all
  /// hands are held.
  virtual std::shared_ptr<PageHand> take(const PageHandRequest& request) = 0;
  /// New hands trust the server with this certificate. From any thread.
  virtual void trust(const Fingerprint& fingerprint) = 0;
};

/// The settings of all page hands.
struct PageHandsSetup {
  std::string host;  // address of the server's control port from this machine
  std::uint16_t port = 0;
  Fingerprint fingerprint;  // of its certificate
  std::size_t most = 0;     // largest number of hands at once
};
using MakePageHands = std::function<std::unique_ptr<PageHands>(const PageHandsSetup& setup)>;

}  // namespace feltwire::web
