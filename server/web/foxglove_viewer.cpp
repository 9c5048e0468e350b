#include "server/web/foxglove_viewer.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/visible_text.hpp"
#include "core/recording/sample_messages.hpp"

namespace feltwire::web {

FoxgloveViewer::FoxgloveViewer(Viewer& viewer, std::string_view scene) : viewer_(viewer) {
  viewer_.send(foxglove_server_info(scene));
  viewer_.send(foxglove_advertisement());
}

void FoxgloveViewer::complain(const std::string& message) {
  viewer_.send(foxglove_status(FoxgloveLevel::error, message));
}

void FoxgloveViewer::receive(std::string_view message) {
  const std::optional<FoxgloveRequest> request = parse_foxglove_request(message);
  if (!request)
    return complain("a message is not a JSON object with \"op\", or has an id that is no number");
  if (request->operation == "subscribe") {
    for (const auto& wanted : request->subscriptions) subscribe(wanted);
  } else if (request->operation == "unsubscribe") {
    for (const std::uint32_t id : request->ended) unsubscribe(id);
  } else {
    constexpr std::size_t kShown = 40;
    complain("this server only shows: it has no operation \"" +
             visible(std::string_view(request->operation).substr(0, kShown)) + "\"");
  }
}

void FoxgloveViewer::subscribe(const FoxgloveRequest::Subscription& wanted) {
  if (wanted.channel >= kFoxgloveChannels)
    return complain("there is no channel " + std::to_string(wanted.channel));
  const bool known = std::ranges::any_of(
      subscriptions_, [&](const auto& other) { return other && other->id == wanted.id; });
  if (known || subscriptions_[wanted.channel])
    return complain("subscription " + std::to_string(wanted.id) + " or channel " +
                    std::to_string(wanted.channel) + " is in use; unsubscribe first");
  subscriptions_[wanted.channel] = Subscription{wanted.id};
}

void FoxgloveViewer::unsubscribe(std::uint32_t id) {
  const auto found = std::ranges::find_if(subscriptions_, [&](const auto& subscription) {
    return subscription && subscription->id == id;
  });
  if (found == subscriptions_.end())
    return complain("there is no subscription " + std::to_string(id));
  found->reset();
}

void FoxgloveViewer::show(const FoxgloveScene& scene) {
  for (std::size_t i = 0; i < kFoxgloveChannels; ++i)
    if (subscriptions_[i]) send(static_cast<FoxgloveChannel>(i), scene, *subscriptions_[i]);
}

void FoxgloveViewer::send(FoxgloveChannel channel, const FoxgloveScene& scene,
                          Subscription& subscription) {
  const FoxgloveTopic& topic = scene.topic(channel);
  if (topic.revision == subscription.sent) return;
  subscription.sent = topic.revision;
  if (channel != FoxgloveChannel::picture)
    return viewer_.show_binary(foxglove_data_head(subscription.id, topic.time), topic.payload);
  // Delete all hands that have left since this viewer's last picture. It may have missed pictures.
  std::vector<std::uint32_t> gone;
  std::ranges::set_difference(hands_, scene.hands(), std::back_inserter(gone));
  hands_ = scene.hands();
  std::string payload;
  for (const std::uint32_t hand : gone)
    append_deletion(payload, topic.time, foxglove_hand_id(hand));
  Bytes begin = foxglove_data_head(subscription.id, topic.time);
  begin.insert(begin.end(), payload.begin(), payload.end());
  viewer_.show_binary(begin, topic.payload);
}

}  // namespace feltwire::web
