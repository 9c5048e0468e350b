#pragma once
// The objects of a scene, as a point shell meets them.

#include <span>

#include "core/point_shell/object_motion.hpp"
#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// Objects, and how they moved in the step. Everything that it is made of outlives it.
class ShellSurroundings final : public ToolSurroundings {
 public:
  /// `contact_area` [m^2]: as in add_contact(). `motions`: one for each object; empty: all are
  /// static.
  ShellSurroundings(const PointShell& shell, double contact_area, std::span<const Object> objects,
                    std::span<const ObjectMotion> motions = {})
      : shell_(shell), contact_area_(contact_area), objects_(objects), motions_(motions) {}

  using ToolSurroundings::contact;
  ShellContact contact(const Pose& tool, WorkLimit* work) const noexcept override {
    ShellContact sum;
    for (std::size_t i = 0; i < objects_.size() && !is_cut(work); ++i)
      add_contact(shell_, tool, objects_[i], contact_area_, sum,
                  in_step(i, objects_[i], motions_, tool), work);
    return sum;
  }

 private:
  const PointShell& shell_;
  double contact_area_;
  std::span<const Object> objects_;
  std::span<const ObjectMotion> motions_;
};

}  // namespace feltwire
