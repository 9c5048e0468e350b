#include "server/scene/scene_log.hpp"

#include <array>

#include "core/base/splitmix.hpp"

namespace feltwire {
namespace {

std::uint64_t digest_of(const Pose& pose) noexcept {
  const std::array<double, 7> numbers = {
      pose.position.x(),    pose.position.y(),    pose.position.z(),   pose.orientation.w(),
      pose.orientation.x(), pose.orientation.y(), pose.orientation.z()};
  return digest({reinterpret_cast<const std::uint8_t*>(numbers.data()), sizeof numbers});
}

}  // namespace

void SceneLog::put_end(std::uint32_t hand, SessionEnd how) noexcept {
  const auto cause = static_cast<std::uint8_t>(how);
  put({.kind = EventKind::end, .hand = hand, .time = newest_, .payload = {&cause, 1}});
}

void SceneLog::check(const World* world, Nanoseconds now) noexcept {
  if (log_ == nullptr) return;
  std::uint64_t sum = 0;
  if (world != nullptr)
    for (std::size_t i = world->view().still(); i < world->objects().size(); ++i)
      sum = splitmix::mix(sum + digest_of(world->objects()[i].pose));
  put({.kind = EventKind::check, .time = now, .digest = sum});
}

std::vector<std::uint8_t> SceneLog::payload(const control::Message& message) const {
  if (log_ == nullptr) return {};
  std::vector<std::uint8_t> frame = control::encode(message);
  frame.erase(frame.begin(), frame.begin() + control::kFrameLengthSize);
  return frame;
}

}  // namespace feltwire
