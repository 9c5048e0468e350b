#pragma once
// The events of a scene on their way into its log.

#include <memory>
#include <vector>

#include "core/base/captured_files.hpp"
#include "core/dynamics/world.hpp"
#include "protocol/wire/control.hpp"
#include "server/scene/event_log.hpp"
#include "server/scene/session_end.hpp"

namespace feltwire {

/// Puts the inputs that decide a scene's replies into a log. Without a log it does nothing.
class SceneLog {
 public:
  /// `log` must outlive this; null: there is no log any more.
  void log_to(EventLog* log) noexcept { log_ = log; }
  bool is_on() const noexcept { return log_ != nullptr; }

  /// Never allocates.
  void put(const SceneEvent& event) noexcept {
    if (log_ == nullptr) return;
    newest_ = event.time;
    log_->put(event);
  }
  /// The end of a session, at the time of the newest event. Never allocates.
  void put_end(std::uint32_t hand, SessionEnd how) noexcept;
  /// The places of all moving objects, for a replay to compare. `world` null: nothing moves. Never
  /// allocates.
  void check(const World* world, Nanoseconds now) noexcept;

  /// The payload of an event that a control message causes: the body of its frame. Empty without a
  /// log. Allocates, so make it before the change.
  std::vector<std::uint8_t> payload(const control::Message& message) const;
  /// The files of the scene after the next event, a reload; null: they were not kept. Allocates.
  void announce(const std::shared_ptr<const CapturedFiles>& files) {
    if (log_ != nullptr) log_->announce(files);
  }

 private:
  EventLog* log_ = nullptr;
  Nanoseconds newest_{0};  // the time of the newest event
};

}  // namespace feltwire
