#pragma once
// The share with which a hand leads a robot together with others.

#include <optional>
#include <string>

namespace feltwire {

/// 0: the hand leads alone. Otherwise its weight among the hands that lead together is this over
/// the sum (SharedClutchOffset).
inline constexpr double kLeastLeadShare = 0.01, kMostLeadShare = 100.0;

/// The reason why there is no such share: the range and the remedy. Empty if there is. NaN is no
/// share.
inline std::optional<std::string> wrong_lead_share(double share) {
  if (share == 0.0 || (share >= kLeastLeadShare && share <= kMostLeadShare)) return std::nullopt;
  return "must be 0 (the hand leads alone), or 0.01 to 100; correct it";
}

}  // namespace feltwire
