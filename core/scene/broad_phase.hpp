#pragma once
// Finds the objects that a tool can meet on its way. A scene of thousands of objects then costs
// only as much as the few near the tool.

#include <span>

#include "core/contact/contact.hpp"
#include "core/mesh/box_tree.hpp"

namespace feltwire {

/// A ball that contains the object.
struct ReachBall {
  Vec3 middle = Vec3::Zero();  // [m, object frame]
  double radius = 0.0;         // [m] infinite if no ball holds the object
};
ReachBall reach_ball(const Object& object);

/// Immutable.
class BroadPhase {
 public:
  /// Fewer objects than this have no tree, because evaluating each one costs no more.
  static constexpr std::size_t kFew = 16;

  BroadPhase() = default;
  /// For a tool that is a ball of `radius` [m]; 0: a point.
  explicit BroadPhase(std::span<const Object> objects, double radius = 0.0);

  /// Whether there is a tree. Without one, evaluate every object.
  bool in_use() const { return !tree_.empty(); }
  /// Objects without bounds, such as planes and hollows: evaluate these at every sample.
  std::span<const std::uint32_t> everywhere() const { return everywhere_; }
  /// Visits each other object whose box the straight way between two points [m] meets, once. The
  /// order is not defined.
  template <class Visit>
  void along(const Vec3& from, const Vec3& to, Visit visit) const noexcept {
    tree_.along(from, to, [&](std::uint32_t i) { visit(bounded_[i]); });
  }

 private:
  std::vector<std::uint32_t> everywhere_, bounded_;
  BoxTree tree_;  // over the bounded
};

}  // namespace feltwire
