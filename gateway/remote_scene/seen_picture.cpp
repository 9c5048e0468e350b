#include "gateway/remote_scene/seen_picture.hpp"

namespace feltwire {
namespace {

constexpr double kSmallForce = 0.01;  // [N] less is no force
constexpr std::uint32_t kKnownStates = (1u << kHandStates) - 1u;

PictureHand picture_of(const SeenHand& seen) {
  PictureHand hand;
  hand.number = seen.number;
  hand.pose = seen.pose;
  hand.held = seen.force;
  if (!seen.figures) {
    hand.proxy = seen.pose.position;
    hand.states =
        bit(seen.force.norm() > kSmallForce ? HandState::touching : HandState::free_space);
    return hand;
  }
  const HandFigures& figures = *seen.figures;
  hand.states = figures.states & kKnownStates;
  hand.report = figures.report;
  hand.proxy = figures.proxy;
  hand.elastic = figures.elastic;
  hand.frictional = figures.frictional;
  hand.depth = figures.depth;
  hand.delivered = figures.delivered;
  hand.burned = figures.burned;
  hand.samples = figures.samples;
  hand.missed = figures.missed;
  return hand;
}

}  // namespace

void draw(const ObservedScene& seen, const Scene& scene, Picture& picture) {
  picture.hands.clear();
  picture.bodies.clear();
  picture.robots.clear();
  for (const auto& [seat, robot] : seen.robots()) picture.robots.push_back(robot);
  for (const auto& [number, hand] : seen.hands()) picture.hands.push_back(picture_of(hand));
  const std::size_t still = scene.views().front().still(), end = scene.objects().size();
  for (const auto& [object, body] : seen.bodies())
    if (object >= still && object < end) picture.bodies.push_back({object, body.pose});
}

std::vector<HandDescription> hands_of(const ObservedScene& seen, const Scene& scene) {
  std::vector<HandDescription> hands;
  for (const auto& [number, hand] : seen.hands()) {
    const std::size_t tool = hand.figures ? hand.figures->tool : 0;
    const std::string name =
        tool < scene.views().size() ? scene.views()[tool].tool().name : std::string();
    hands.push_back({number, 0, {}, {}, name, {}});
  }
  return hands;
}

}  // namespace feltwire
