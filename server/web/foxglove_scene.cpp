#include "server/web/foxglove_scene.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/recording/live_messages.hpp"
#include "core/recording/sample_messages.hpp"
#include "server/web/object_triangles.hpp"

namespace feltwire::web {
namespace {

std::string frame_of(std::size_t object) { return "body " + std::to_string(object); }

void append_object(std::string& out, std::uint64_t time, const Scene& scene, std::size_t index) {
  const Object& object = scene.objects()[index];
  if (std::holds_alternative<Plane>(object.shape)) {
    append_triangles(out, time, object.name, plane_square(),
                     square_pose(object.pose, scene.start().position));
    return;
  }
  const TriangleSoup soup = triangles_of(object.shape);
  if (soup.triangles.empty()) return;
  if (index < scene.views().front().still())
    append_triangles(out, time, object.name, soup, object.pose);
  else
    append_triangles(out, time, object.name, soup, Pose{}, frame_of(index));
}

std::vector<std::string_view> reasons_of(const PictureHand& hand) {
  std::vector<std::string_view> reasons;
  for (std::size_t i = 0; i < kHandStates; ++i)
    if (const auto state = static_cast<HandState>(i); (hand.states & bit(state)) != 0)
      reasons.emplace_back(name(state));
  if (hand.report)
    for_each_reason(hand.report->reasons,
                    [&](std::string_view reason) { reasons.push_back(reason); });
  return reasons;
}

LiveHand live(const PictureHand& hand) {
  LiveHand shown{.number = hand.number,
                 .pose = hand.pose,
                 .proxy = hand.proxy,
                 .elastic = hand.elastic,
                 .frictional = hand.frictional,
                 .held = hand.held,
                 .depth = hand.depth,
                 .delivered = hand.delivered,
                 .burned = hand.burned,
                 .samples = hand.samples,
                 .missed = hand.missed,
                 .reasons = reasons_of(hand)};
  if (hand.report && hand.report->has_account) shown.balance = hand.report->balance;
  if (hand.report && hand.report->round_trip > 0.0) shown.round_trip = hand.report->round_trip;
  return shown;
}

}  // namespace

std::string foxglove_hand_id(std::uint32_t number) { return "hand " + std::to_string(number); }

void FoxgloveScene::put(FoxgloveChannel channel, std::uint64_t time, std::string payload) {
  FoxgloveTopic& topic = topics_[static_cast<std::size_t>(channel)];
  topic = {SharedBytes(std::move(payload)), time, topic.revision + 1};
}

void FoxgloveScene::set(const Scene& scene, std::uint32_t version, Nanoseconds now) {
  if (version == version_) return;
  version_ = version;
  const std::uint64_t time = time_of(now);
  std::string geometry, transforms;
  append_deletion_of_all(geometry, time);
  for (std::size_t i = 0; i < scene.objects().size(); ++i) append_object(geometry, time, scene, i);
  for (std::size_t i = scene.views().front().still(); i < scene.objects().size(); ++i)
    append_transform(transforms, time, frame_of(i), scene.objects()[i].pose);
  put(FoxgloveChannel::geometry, time, std::move(geometry));
  put(FoxgloveChannel::transforms, time, std::move(transforms));
}

void FoxgloveScene::set(const Picture& picture) {
  const std::uint64_t time = time_of(picture.time);
  std::string entities, transforms, figures;
  std::vector<LiveHand> hands;
  hands_.clear();
  for (const PictureHand& hand : picture.hands) {
    hands_.push_back(hand.number);
    hands.push_back(live(hand));
    append_hand(entities, time, foxglove_hand_id(hand.number), hand.pose, hand.held);
  }
  for (const PictureBody& body : picture.bodies)
    append_transform(transforms, time, frame_of(body.object), body.pose);
  append(figures, seconds(picture.time), hands);
  std::ranges::sort(hands_);
  put(FoxgloveChannel::picture, time, std::move(entities));
  put(FoxgloveChannel::hands, time, std::move(figures));
  if (!transforms.empty()) put(FoxgloveChannel::transforms, time, std::move(transforms));
}

}  // namespace feltwire::web
