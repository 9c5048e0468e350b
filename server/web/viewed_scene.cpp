#include "server/web/viewed_scene.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "protocol/net/post.hpp"

namespace feltwire::web {
namespace {

constexpr Nanoseconds kBetweenDescriptions = std::chrono::milliseconds(500);

}  // namespace

void ViewedScene::show(std::span<ViewerSlot* const> viewers, Nanoseconds now) {
  follow(scene_.current_scene());
  tell_of_sight(viewers);
  // Skip a viewer to which earlier messages are still being sent.
  std::vector<ViewerSlot*> ready;
  for (ViewerSlot* slot : viewers) {
    if (slot->foxglove) continue;
    if (slot->viewer->ready())
      ready.push_back(slot);
    else
      ++skipped_;
  }
  for (ViewerSlot* slot : ready)
    if (slot->version != version_) {
      show_scene(*slot);
    } else if (slot->changes != changes_) {
      slot->changes = changes_;
      slot->viewer->show_text(materials_);
    }

  const bool news = scene_.take_picture(picture_);
  if (news && picture_.version == version_) {
    const SharedBytes shown(picture(picture_, rates_, begin_));
    const SharedBytes near(surfaces(picture_));
    for (ViewerSlot* slot : ready) {
      slot->viewer->show_binary(shown);
      if (!near.empty()) slot->viewer->show_binary(near);
    }
    pictures_ += ready.size();
  }
  show_in_foxglove(viewers, now, news);
  if (now - described_ < kBetweenDescriptions || describing_) return;
  described_ = now;
  describing_ = true;
  count_rates();
  const SharedBytes text(sessions(hands_, picture_, rates_, seconds(now - begin_)));
  for (ViewerSlot* slot : ready) slot->viewer->show_text(text);
  describe();
}

/// Updates the messages about the scene if the scene has changed.
void ViewedScene::follow(const SceneInView::CurrentScene& current) {
  if (current.version != version_) {
    text_ = SharedBytes(scene_text(*current.scene, current.version));
    geometry_.clear();
    for (Bytes& object : geometry(*current.scene, current.version))
      geometry_.emplace_back(std::move(object));
    version_ = current.version;
    materials_ = {};
  }
  if (materials_.empty() || current.changes != changes_) {
    materials_ = SharedBytes(materials_text(*current.scene, current.version, current.gravity));
    changes_ = current.changes;
  }
}

/// Tells the viewers that the scene can no longer be seen, or that it can be seen again.
void ViewedScene::tell_of_sight(std::span<ViewerSlot* const> viewers) {
  std::optional<std::string> hidden = scene_.out_of_sight();
  if (hidden == hidden_) return;
  const std::string line =
      hidden ? log_text("error", *hidden) : log_text("info", "Scene " + name() + " is seen.");
  hidden_ = std::move(hidden);
  for (ViewerSlot* slot : viewers)
    if (!slot->foxglove && slot->version != 0) slot->viewer->send(line);
}

void ViewedScene::show_scene(ViewerSlot& slot) {
  slot.version = version_;
  slot.changes = changes_;
  slot.viewer->show_text(text_);
  for (const SharedBytes& object : geometry_) slot.viewer->show_binary(object);
  slot.viewer->show_text(materials_);
  if (hidden_) slot.viewer->send(log_text("error", *hidden_));
}

/// Sends the newest scene and picture to the viewers that use the Foxglove protocol.
void ViewedScene::show_in_foxglove(std::span<ViewerSlot* const> viewers, Nanoseconds now,
                                   bool news) {
  bool encoded = false;
  for (ViewerSlot* slot : viewers) {
    if (!slot->foxglove) continue;
    if (!slot->viewer->ready()) {
      ++skipped_;
      continue;
    }
    if (!std::exchange(encoded, true)) {
      foxglove_.set(*scene_.current_scene().scene, version_, now);
      if (news && picture_.version == version_) foxglove_.set(picture_);
    }
    slot->foxglove->show(foxglove_);
    if (news) ++pictures_;
  }
}

/// Computes the sample rate and the loss of each hand, from the counters in the newest picture and
/// in the picture of half a second before.
void ViewedScene::count_rates() {
  const double elapsed = seconds(picture_.time - counted_.time);
  rates_.clear();
  for (const PictureHand& hand : picture_.hands) {
    HandRates rates;
    rates.number = hand.number;
    const auto before = std::ranges::find(counted_.hands, hand.number, &PictureHand::number);
    if (before != counted_.hands.end() && elapsed > 0.0) {
      const auto taken = static_cast<double>(hand.samples - before->samples);
      const auto missed = static_cast<double>(hand.missed - before->missed);
      rates.samples = taken / elapsed;
      rates.loss = taken + missed > 0.0 ? missed / (taken + missed) : 0.0;
    }
    rates_.push_back(rates);
  }
  std::ranges::sort(rates_, {}, &HandRates::number);
  counted_ = picture_;
}

/// Requests new descriptions of the hands from the scene, and stores them when they come.
void ViewedScene::describe() {
  scene_.describe(post_to(io_),
                  [this, alive = std::weak_ptr(alive_)](std::vector<HandDescription> hands) {
                    if (alive.expired()) return;
                    hands_ = std::move(hands);
                    describing_ = false;
                  });
}

}  // namespace feltwire::web
