#pragma once
// The hands and bodies that an observer has seen, assembled from the views in its replies. A
// program that draws the scene gets it by RunOptions::on_view (run_client.hpp).
//
// A hostile server can show new hands without end. So the number kept is limited, and those left
// out are counted.

#include <map>
#include <vector>

#include "protocol/wire/scene_view.hpp"

namespace feltwire {

class ObservedScene {
 public:
  static constexpr std::size_t kMostHands = 1024;   // 16 times what a server admits by default
  static constexpr std::size_t kMostBodies = 4096;  // objects that move

  /// Takes the next view, of a newer reply than the one before. Entries within its ranges that it
  /// does not contain are removed. Hands and bodies without room are left out and counted.
  void take(const SceneView& view);

  const std::map<std::uint32_t, SeenHand>& hands() const { return hands_; }    // by number
  const std::map<std::uint16_t, SeenBody>& bodies() const { return bodies_; }  // by object
  /// The robots on the scene's seats, by seat.
  const std::map<std::uint8_t, SeenRobot>& robots() const { return robots_; }
  /// The seats whose robots are gone since the last view.
  const std::vector<std::uint8_t>& robots_gone() const { return robots_gone_; }
  /// The hands that are gone since the last view.
  const std::vector<std::uint32_t>& hands_gone() const { return hands_gone_; }
  const std::vector<std::uint16_t>& bodies_gone() const { return bodies_gone_; }
  /// The number of times that a shown hand or body had no room.
  std::uint64_t left_out() const { return left_out_; }

 private:
  std::map<std::uint32_t, SeenHand> hands_;
  std::map<std::uint16_t, SeenBody> bodies_;
  std::map<std::uint8_t, SeenRobot> robots_;
  std::vector<std::uint8_t> robots_gone_;
  std::vector<std::uint32_t> hands_gone_;
  std::vector<std::uint16_t> bodies_gone_;
  std::uint64_t left_out_ = 0;
};

}  // namespace feltwire
