#include "server/scene/event_log.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "core/base/splitmix.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kWord = sizeof(std::uint64_t);
constexpr std::size_t kHead = 5;  // number of words of an event before its payload
constexpr unsigned kOutcomeAt = 8, kHandAt = 32;
constexpr std::uint64_t kByte = 0xff;
constexpr std::array<const char*, static_cast<std::size_t>(EventKind::count_of_kinds)> kNames = {
    "none",   "join",   "parameters", "samples", "tick", "end",
    "reload", "change", "check",      "path",    "pace"};

std::size_t words_of(std::size_t bytes) { return (bytes + kWord - 1) / kWord; }

}  // namespace

const char* name(EventKind kind) noexcept { return kNames[static_cast<std::size_t>(kind)]; }

std::uint64_t digest(Bytes bytes) noexcept {
  std::uint64_t sum = bytes.size();
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t size = std::min(kWord, bytes.size());
    std::memcpy(&word, bytes.data(), size);
    sum = splitmix::mix(sum + splitmix::kStep + word);
    bytes = bytes.subspan(size);
  }
  return splitmix::mix(sum + splitmix::kStep);
}

EventQueue::EventQueue(std::size_t bytes)
    : ring_(words_of(bytes)),
      written_(kHead + words_of(kMostPayload)),
      read_(kHead + words_of(kMostPayload)) {}

bool EventQueue::push(const SceneEvent& event) noexcept {
  const std::size_t size = event.payload.size();
  if (size > kMostPayload) return false;
  const std::size_t words = kHead + words_of(size);
  written_[0] = static_cast<std::uint64_t>(event.kind) |
                static_cast<std::uint64_t>(event.outcome) << kOutcomeAt |
                std::uint64_t{event.hand} << kHandAt;
  written_[1] = static_cast<std::uint64_t>(event.time.count());
  written_[2] = event.digest;
  written_[3] = event.number;
  written_[4] = size;
  if (size > 0) {
    written_[words - 1] = 0;
    std::memcpy(&written_[kHead], event.payload.data(), size);
  }
  return ring_.push(std::span<const std::uint64_t>(written_).first(words));
}

std::optional<SceneEvent> EventQueue::take() noexcept {
  const std::span<std::uint64_t> words(read_);
  if (!ring_.pop(words.first(kHead))) return std::nullopt;
  const auto size = static_cast<std::size_t>(words[4]);
  ring_.pop(words.subspan(kHead, words_of(size)));
  return SceneEvent{
      .kind = static_cast<EventKind>(words[0] & kByte),
      .outcome = static_cast<EventOutcome>(words[0] >> kOutcomeAt & kByte),
      .hand = static_cast<std::uint32_t>(words[0] >> kHandAt),
      .time = Nanoseconds(static_cast<std::int64_t>(words[1])),
      .digest = words[2],
      .payload = {reinterpret_cast<const std::uint8_t*>(words.subspan(kHead).data()), size},
      .number = words[3]};
}

void EventLog::announce(std::shared_ptr<const CapturedFiles> files) {
  const std::lock_guard lock(mutex_);
  announced_.push_back({number_ + 1, std::move(files)});
}

std::shared_ptr<const CapturedFiles> EventLog::files_of(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  while (!announced_.empty() && announced_.front().number < number) announced_.pop_front();
  if (announced_.empty() || announced_.front().number != number) return nullptr;
  return announced_.front().files;
}

}  // namespace feltwire
