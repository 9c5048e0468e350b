#pragma once

#include "sim/published_laws/contact_force.hpp"

namespace feltwire {

/// Successive force augmentation: a spring of low stiffness k0, which is stable, and an offset that
/// is added to its force step by step until the stiff environment's force is reached.
///   F(n) = F(n-1) + k0 dx(n) + step(n),   0 <= F(n) <= F_e(n)
///   step(n) = (F_e(n) - F(n-1) - k0 dx(n)) / 10 where a press begins, else 0
/// Source: H. Singh, A. Jafari, J.-H. Ryu, "Enhancing the rate-hardness of haptic interaction:
/// successive force augmentation approach", IEEE Trans. Industrial Electronics 67(1), 2020 (online
/// 2019).
/// Taken from its abstract: a feed-forward offset is added to the feedback force of a low
/// stiffness, successively. Not available, decided here: k0 is 2 b / T, the stiffest that is
/// passive. The offset grows where the hand turns to move in, by a tenth of the missing force. A
/// part that would lift the force above F_e(n) is dropped. So this is a law after the abstract; it
/// does not reproduce their experiments.
///
/// With `transient` their extension for rate-hardness, after the same abstract: the surface's own
/// stiffness during the transient response, then as above. Decided here: the transient lasts from
/// the begin of a contact until the hand turns to move out.
class ForceAugmentation {
 public:
  explicit ForceAugmentation(double low_stiffness, bool transient = false)
      : low_stiffness_(low_stiffness), transient_(transient), lands_(transient) {}

  Command step(const BoundingStep& s) noexcept {
    constexpr double kShare = 0.1;
    const ContactForce contact(s);
    if (!(contact.wanted > 0.0)) {
      force_ = 0.0;
      pressing_ = false;
      lands_ = transient_;
      return {};
    }
    lands_ = lands_ && contact.inward >= 0.0;
    if (lands_) {
      force_ = contact.wanted;
      pressing_ = true;
      return contact.rendered(force_);
    }
    force_ += low_stiffness_ * contact.inward;
    const bool begins = contact.inward > 0.0 && !pressing_;
    if (begins && contact.wanted > force_) force_ += kShare * (contact.wanted - force_);
    if (contact.inward != 0.0) pressing_ = contact.inward > 0.0;
    force_ = std::clamp(force_, 0.0, contact.wanted);
    return contact.rendered(force_);
  }
  void set_held(const Command& held) noexcept {
    force_ = std::min(force_, held.force().dot(direction(held.elastic)));
  }

 private:
  double low_stiffness_;    // k0 [N/m]
  bool transient_, lands_;  // the surface's own stiffness at first; now
  double force_ = 0.0;      // F(n-1) [N] along the normal
  bool pressing_ = false;   // the hand moved in during the last sample
};

}  // namespace feltwire
