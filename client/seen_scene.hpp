#pragma once
// What an observer knows of a scene, put together from the views that its replies bring. A program
// that draws the scene needs this and a Ring of LoopOutputs::views.

#include <map>
#include <vector>

#include "protocol/scene_view.hpp"

namespace feltwire {

class SeenScene {
 public:
  /// The next view, of a newer reply than the one before. What is within its ranges and not in it
  /// is forgotten.
  void take(const SceneView& view);

  const std::map<std::uint32_t, SeenHand>& hands() const { return hands_; }    // by number
  const std::map<std::uint16_t, SeenBody>& bodies() const { return bodies_; }  // by object
  /// What the last view made it forget.
  const std::vector<std::uint32_t>& hands_gone() const { return hands_gone_; }
  const std::vector<std::uint16_t>& bodies_gone() const { return bodies_gone_; }

 private:
  std::map<std::uint32_t, SeenHand> hands_;
  std::map<std::uint16_t, SeenBody> bodies_;
  std::vector<std::uint32_t> hands_gone_;
  std::vector<std::uint16_t> bodies_gone_;
};

}  // namespace feltwire
