#pragma once
// Which of many objects a tool can meet on its way: a scene of thousands costs what the few near
// the tool cost.

#include <span>

#include "core/contact/contact.hpp"
#include "core/mesh/box_tree.hpp"

namespace feltwire {

/// A ball that a point is outside of the object beyond, however the object is turned.
struct ReachBall {
  Vec3 middle = Vec3::Zero();  // [m, object frame]
  double radius = 0.0;         // [m] infinite where there is none
};
ReachBall reach_ball(const Object& object);

class BroadPhase {
 public:
  /// Fewer objects than this are asked one by one, which is no dearer.
  static constexpr std::size_t kFew = 16;

  BroadPhase() = default;
  /// For a tool that is a ball of `radius` [m], 0: a point.
  explicit BroadPhase(std::span<const Object> objects, double radius = 0.0);

  /// There is one; without, every object is to be asked.
  bool in_use() const { return !tree_.empty(); }
  /// Objects that have no end, or that a tool is outside of everywhere: always to be asked.
  std::span<const std::uint32_t> everywhere() const { return everywhere_; }
  /// Visits the others whose box the way between two points [m] meets, each once, in no order.
  template <class Visit>
  void along(const Vec3& from, const Vec3& to, Visit visit) const noexcept {
    tree_.along(from, to, [&](std::uint32_t i) { visit(bounded_[i]); });
  }

 private:
  std::vector<std::uint32_t> everywhere_, bounded_;
  BoxTree tree_;  // over the bounded
};

}  // namespace feltwire
