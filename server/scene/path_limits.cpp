#include "server/scene/path_limits.hpp"

#include <algorithm>
#include <array>
#include <chrono>

namespace feltwire {
namespace {

constexpr std::chrono::minutes kTriedAgain{1};  // time after which longer replies are tried again

}  // namespace

void PathLimits::limit(SessionSlot& slot, std::size_t payload, Nanoseconds now) noexcept {
  PathRoom& path = slot.path;
  path.room = std::min(payload, kMaxPayload);
  path.until = now + kTriedAgain;
  if (path.room < kMaxPayload && !path.was_short) path.was_short = has_short_paths_ = true;
  const auto low = static_cast<std::uint8_t>(path.room & 0xff),
             high = static_cast<std::uint8_t>(path.room >> 8);
  const std::array<std::uint8_t, 2> bytes{low, high};
  log_.put({.kind = EventKind::path, .hand = slot.number, .time = now, .payload = bytes});
}

std::size_t PathLimits::room(SessionSlot& slot, Nanoseconds now) noexcept {
  if (slot.path.room < kMaxPayload && now >= slot.path.until) limit(slot, kMaxPayload, now);
  return slot.path.room;
}

std::vector<std::string> PathLimits::short_paths(const SessionSlots& slots) {
  std::vector<std::string> lines;
  has_short_paths_ = false;
  for (const auto& slot : slots) {
    PathRoom& path = slot->path;
    if (!path.was_short || path.told) continue;
    path.told = true;
    lines.push_back("session " + std::to_string(slot->number) + " (" + slot->session.client() +
                    "): the path to its client takes no datagrams above " +
                    std::to_string(path.room + kOverhead) +
                    " bytes; its replies carry less of the local model or the view, so that they "
                    "arrive; an MTU of 1280 on the whole way takes all of it");
  }
  return lines;
}

}  // namespace feltwire
