#include <algorithm>
#include <condition_variable>
#include <list>
#include <mutex>

#include "gateway/page_hand/make_page_hands.hpp"
#include "gateway/page_hand/page_hand.hpp"

namespace feltwire {
namespace {

/// Starts the page hands from a thread of its own. A new thread inherits the priority of the thread
/// that starts it. A servo must have normal priority, but the page's thread has a low priority.
class ClientPageHands final : public web::PageHands {
 public:
  explicit ClientPageHands(const web::PageHandsSetup& setup)
      : most_(setup.most), server_{{setup.host, setup.port}, {setup.fingerprint, {}, {}, {}}} {
    starter_ = std::thread([this] { start_hands(); });
  }

  ~ClientPageHands() override {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    starter_.join();
    // Release all hands first, because each destructor waits until its hand has ended.
    for (const auto& hand : hands_) hand->release();
  }

  std::shared_ptr<web::PageHand> take(const web::PageHandRequest& request) override {
    std::shared_ptr<ClientPageHand> hand;
    {
      const std::lock_guard lock(mutex_);
      // Remove only hands that have ended. A hand whose viewer has left may still run.
      std::erase_if(hands_, [](const auto& held) { return held->over(); });
      if (hands_.size() + asked_.size() >= most_) return nullptr;
      hand = std::make_shared<ClientPageHand>(server_, request);
      asked_.push_back(hand);
    }
    changed_.notify_all();
    return hand;
  }

  void trust(const Fingerprint& fingerprint) override {
    const std::lock_guard lock(mutex_);
    server_.credentials.trust = fingerprint;
  }

 private:
  using Hands = std::list<std::shared_ptr<ClientPageHand>>;

  void start_hands() noexcept {
    std::unique_lock lock(mutex_);
    while (!ended_) {
      changed_.wait(lock, [this] { return ended_ || !asked_.empty(); });
      for (const auto& hand : asked_) hand->start();
      hands_.splice(hands_.end(), asked_);
    }
  }

  const std::size_t most_;
  std::mutex mutex_;
  ServerAccess server_;  // guarded by mutex_
  std::condition_variable changed_;
  bool ended_ = false;   // guarded by mutex_, as are asked_ and hands_
  Hands asked_, hands_;  // hands to be started; running hands
  std::thread starter_;
};

}  // namespace

std::unique_ptr<web::PageHands> make_page_hands(const web::PageHandsSetup& setup) {
  return std::make_unique<ClientPageHands>(setup);
}

}  // namespace feltwire
