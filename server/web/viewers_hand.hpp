#pragma once
// The hand of one viewer of the live page: it is taken, pointed with and released, and its viewer
// gets messages about it. It has no socket.

#include <memory>
#include <optional>
#include <string>

#include "server/web/page_hands.hpp"

namespace feltwire::web {

class ViewersHand {
 public:
  static constexpr double kFarthest = 10.0;  // [m] of a target, on each axis

  /// A viewer that may hold no hand.
  ViewersHand() = default;
  /// A viewer that may hold one, with this name and this token. `hands` outlives this.
  ViewersHand(PageHands& hands, std::string client, Secret token)
      : hands_(&hands), client_(std::move(client)), token_(std::move(token)) {}
  ~ViewersHand() { release(); }
  ViewersHand(ViewersHand&&) noexcept = default;
  ViewersHand& operator=(ViewersHand&&) noexcept = default;

  bool offered() const { return hands_ != nullptr; }

  /// Takes a hand in the scene, with this bounding method (empty: the usual one); does nothing if
  /// one is held already. news() reports the result.
  void take(const std::string& scene, const std::string& mode = {});
  /// False if the place is not finite or too far away: the hand does not move.
  bool point(const Vec3& target) noexcept;
  void release() noexcept;

  /// A message for the viewer (docs/live_page.md, `hand`) if something has changed since the last
  /// call. The first says whether a hand may be taken.
  std::optional<std::string> news();

 private:
  void refuse(std::string reason);

  PageHands* hands_ = nullptr;
  std::string client_;
  Secret token_;
  std::shared_ptr<PageHand> hand_;
  std::optional<PageHand::State> told_;   // of hand_
  std::optional<std::string> news_ = "";  // why no hand was taken; empty: one may be taken
};

}  // namespace feltwire::web
