#pragma once
// The inputs that decide a scene's replies, on their way from the scene's thread to a recorder's.

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/base/captured_files.hpp"
#include "core/base/ring.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// As in feltwire.Event (core/recording/feltwire.proto), which explains them.
enum class EventKind : std::uint8_t {
  none,
  join,
  parameters,
  samples,
  tick,
  end,
  reload,
  change,
  check,
  path,
  pace,
  count_of_kinds
};
enum class EventOutcome : std::uint8_t { nothing, answered, withheld, count_of_outcomes };
/// "samples"
const char* name(EventKind kind) noexcept;

struct SceneEvent {
  EventKind kind = EventKind::none;
  EventOutcome outcome = EventOutcome::nothing;
  std::uint32_t hand = 0;    // the session's number, from 1 in the order they joined
  Nanoseconds time{0};       // of the scene's clock
  std::uint64_t digest = 0;  // of a reply, or of the state of moving objects
  Bytes payload = {};
  std::uint64_t number = 0;  // from 1; EventLog counts
};

/// 64 bits that identify the bytes. They find differences; they do not resist an attacker.
std::uint64_t digest(Bytes bytes) noexcept;

/// A queue of events from one thread to one other, of bounded size. Neither thread waits.
class EventQueue {
 public:
  static constexpr std::size_t kMostPayload = std::size_t{1} << 17;  // [bytes]

  /// Allocates room for so many bytes of events.
  explicit EventQueue(std::size_t bytes);

  /// For the writing thread. False if there is no room for it, or its payload is too long. Never
  /// allocates.
  bool push(const SceneEvent& event) noexcept;
  /// For the reading thread. Returns the oldest event; its payload is valid until the next call.
  /// Empty: there is none.
  std::optional<SceneEvent> take() noexcept;

 private:
  Ring<std::uint64_t> ring_;
  std::vector<std::uint64_t> written_, read_;  // one event each
};

/// A queue of events from a scene's thread to a recorder's thread. An event that finds no room is
/// lost. The reader sees it by a missing number.
class EventLog {
 public:
  explicit EventLog(std::size_t bytes) : queue_(bytes) {}

  // The scene's thread.
  /// Gives the event its number. Never allocates.
  void put(SceneEvent event) noexcept {
    event.number = ++number_;
    if (!queue_.push(event)) lost_.fetch_add(1, std::memory_order_relaxed);
  }
  /// The files of the scene after the next event, a reload; null: they were not kept. Allocates.
  void announce(std::shared_ptr<const CapturedFiles> files);

  // The recorder's thread.
  /// Like EventQueue::take().
  std::optional<SceneEvent> take() noexcept { return queue_.take(); }
  /// The files of the scene after the reload with this number. Null: they are not known.
  std::shared_ptr<const CapturedFiles> files_of(std::uint64_t number);

  /// Events that found no room so far, from any thread.
  std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  struct Announced {
    std::uint64_t number;
    std::shared_ptr<const CapturedFiles> files;
  };

  EventQueue queue_;
  std::uint64_t number_ = 0;
  std::atomic<std::uint64_t> lost_{0};
  std::mutex mutex_;  // guards the next member, only at a reload
  std::deque<Announced> announced_;
};

}  // namespace feltwire
