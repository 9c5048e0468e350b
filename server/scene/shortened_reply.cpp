// Leaves out parts of a reply that is too long for its path, first those of the model.

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <vector>

#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kPatchBytes = 96, kBodyPointBytes = 36;  // of a patch and a point on the wire
constexpr std::size_t kReplyBytes = 288;  // of an observer's reply without the parts of its view
constexpr std::chrono::minutes kTriedAgain{1};  // until longer replies are tried again

/// [m] from the model's center to the place where a patch's surface begins to push; 0: it pushes.
double way_to(const SurfacePatch& patch, const Vec3& center) {
  return patch.touching ? 0.0 : std::max(0.0, (center - patch.point).norm() - patch.offset);
}

/// Drops the farthest patches, and shortens the reach so that it does not cover them.
void drop_farthest(LocalModel& model, int count) {
  for (; count > 0 && model.count > 0; --count) {
    --model.count;
    const SurfacePatch& dropped = model.patches[static_cast<std::size_t>(model.count)];
    model.reach = std::min(model.reach, way_to(dropped, model.center));
  }
  if (!(model.reach > 0.0)) model.count = 0;
}

int parts_of(std::size_t excess, std::size_t size) {
  return static_cast<int>((excess + size - 1) / size);
}

}  // namespace

bool Session::shorten(Reply& reply, std::size_t excess) const noexcept {
  if (reply.modelled && reply.model.count > 0) {
    drop_farthest(reply.model, parts_of(excess, kPatchBytes));
    return true;
  }
  if (reply.modelled) {
    reply.modelled = false;
    return true;
  }
  if (!reply.body_modelled) return false;
  const int most = reply.body.count - parts_of(excess, kBodyPointBytes);
  const std::uint32_t scene = reply.body.scene;
  reply.body = body_model(most);
  reply.body.scene = scene;
  reply.body_modelled = reply.body.reach > 0.0;
  return true;
}

void SceneSessions::limit_replies(std::uint64_t id, std::size_t payload, Nanoseconds now) noexcept {
  SessionSlot** const slot = by_id_.find(id);
  if (slot != nullptr) limit_replies(**slot, payload, now);
}

void SceneSessions::limit_replies(SessionSlot& slot, std::size_t payload,
                                  Nanoseconds now) noexcept {
  slot.room = std::min(payload, kMaxPayload);
  slot.room_until = now + kTriedAgain;
  if (slot.room < kMaxPayload && !slot.was_short) slot.was_short = has_short_paths_ = true;
  const auto low = static_cast<std::uint8_t>(slot.room & 0xff),
             high = static_cast<std::uint8_t>(slot.room >> 8);
  const std::array<std::uint8_t, 2> said{low, high};
  log_.put({.kind = EventKind::path, .hand = slot.number, .time = now, .payload = said});
}

bool SceneSessions::is_limited(std::uint64_t id, std::size_t payload) noexcept {
  SessionSlot** const slot = by_id_.find(id);
  return slot == nullptr || (*slot)->room < payload;
}

/// The reply as bytes, shortened to the session's path as far as its model allows.
Bytes SceneSessions::fitted(SessionSlot& slot, Reply& reply, Nanoseconds now) noexcept {
  Bytes bytes = encoder_.reply(reply);
  if (slot.room == kMaxPayload) [[likely]]
    return bytes;
  if (now >= slot.room_until) {
    limit_replies(slot, kMaxPayload, now);
    return bytes;
  }
  while (bytes.size() > slot.room && slot.session.shorten(reply, bytes.size() - slot.room))
    bytes = encoder_.reply(reply, nullptr, true);
  return bytes;
}

/// [bytes] for the parts of an observer's view.
std::size_t SceneSessions::room_of(SessionSlot& slot, std::size_t whole, Nanoseconds now) noexcept {
  if (slot.room < kMaxPayload && now >= slot.room_until) limit_replies(slot, kMaxPayload, now);
  return std::min(whole, slot.room - std::min(slot.room, kReplyBytes));
}

std::vector<std::string> SceneSessions::short_paths() {
  std::vector<std::string> lines;
  has_short_paths_ = false;
  for (const auto& slot : slots_) {
    if (!slot->was_short || slot->told_short) continue;
    slot->told_short = true;
    lines.push_back("session " + std::to_string(slot->number) + " (" + slot->session.client() +
                    "): the path to its client takes no datagrams above " +
                    std::to_string(slot->room + kOverhead) +
                    " bytes; its replies carry less of the local model or the view, so that they "
                    "arrive; an MTU of 1280 on the whole way takes all of it");
  }
  return lines;
}

}  // namespace feltwire
