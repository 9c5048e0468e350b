#pragma once
// A hand of the live page: a client with a pointed device, in threads of its own.

#include <atomic>
#include <mutex>
#include <thread>

#include "client/hands/pointer_device.hpp"
#include "client/transport/control_client.hpp"
#include "server/web/page_hands.hpp"

namespace feltwire {

/// The device and the arm of such a hand.
PointerHandOptions page_hand_options();

/// Joins by TLS and UDP as any client does, with the usual parameters but for the bounding method
/// of the request, and the limits that protect a hand, and has role pointer.
class ClientPageHand final : public web::PageHand {
 public:
  /// Shows `server` the request's token.
  ClientPageHand(const ServerAccess& server, const web::PageHandRequest& request);
  /// Releases the hand and waits until its session has ended.
  ~ClientPageHand() override;
  ClientPageHand(const ClientPageHand&) = delete;
  ClientPageHand& operator=(const ClientPageHand&) = delete;

  Status status() const override;
  void point(const Vec3& target) noexcept override;
  void release() noexcept override;
  /// Starts the thread that joins; its threads have the priority of the caller's. Call it once. If
  /// the system gives no thread, the hand is released for that reason.
  void start() noexcept;
  /// The session has ended, and no thread of the hand is active any more.
  bool over() const noexcept { return over_.load(); }

 private:
  void run() noexcept;
  std::string hold();
  void end(const char* reason) noexcept;
  void become(Status status) noexcept;

  static constexpr std::size_t kRoom = 256;  // messages: more than come while a thread is late
  ServerAccess server_;
  const std::string scene_, client_, mode_;
  /// Shared, because a servo thread that hangs in its device is left behind with it.
  std::shared_ptr<Ring<PointerMessage>> messages_ = std::make_shared<Ring<PointerMessage>>(kRoom);
  mutable std::mutex mutex_;
  Status status_;  // with the mutex
  std::atomic<bool> over_{false};
  std::thread thread_;
};

}  // namespace feltwire
