#include "server/web/viewers_hand.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "core/bounding/method.hpp"
#include "server/web/page_messages.hpp"

namespace feltwire::web {

void ViewersHand::refuse(std::string reason) { news_ = std::move(reason); }

void ViewersHand::take(const std::string& scene, const std::string& mode) {
  if (hand_ != nullptr) return;
  if (hands_ == nullptr)
    return refuse(
        "this token's role holds no hand, or this server lends none; the role must be pointer, "
        "operator or admin, and --web-hands above 0");
  const std::vector<std::string_view> laws = bounding_method_names();
  if (!mode.empty() && std::ranges::find(laws, mode) == laws.end())
    return refuse("there is no law '" + mode + "'; choose " + bounding_method_choices());
  hand_ = hands_->take({scene, client_, token_, mode});
  if (hand_ == nullptr)
    refuse("all hands of this server (--web-hands) are held; wait until one is let go");
  told_.reset();
}

bool ViewersHand::point(const Vec3& target) noexcept {
  if (!(target.cwiseAbs().maxCoeff() <= kFarthest) || !target.allFinite()) return false;
  if (hand_ != nullptr) hand_->point(target);
  return true;
}

void ViewersHand::release() noexcept {
  if (hand_ != nullptr) hand_->release();
}

std::optional<std::string> ViewersHand::news() {
  if (news_) {
    const std::string reason = *std::exchange(news_, std::nullopt);
    if (!reason.empty()) return hand_text("refused", reason);
    if (offered()) return hand_text("free");
  }
  if (hand_ == nullptr) return std::nullopt;
  const PageHand::Status status = hand_->status();
  if (status.state == told_) return std::nullopt;
  told_ = status.state;
  if (status.state == PageHand::State::released) {
    hand_.reset();
    told_.reset();
  }
  return hand_text(status);
}

}  // namespace feltwire::web
