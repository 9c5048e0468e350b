#pragma once
// A recording of a hand, which the program starts and stops while the hand goes on.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "client/run/recording.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

class HandRecorder;

/// The place of a hand's recorder. The servo thread gives its ticks to it and never waits.
class RecorderPlace {
 public:
  /// The servo thread calls it.
  void add(const TickRecord& tick) noexcept;
  bool is_free() const noexcept { return recorder_.load() == nullptr; }
  /// Returns false if there is a recorder already.
  bool take(HandRecorder& recorder) noexcept;
  /// Returns when the servo thread uses the recorder no more.
  void leave() noexcept;

 private:
  std::atomic<HandRecorder*> recorder_{nullptr};
  std::atomic<bool> in_use_{false};
};

/// Writes every tick from its construction on. A thread of its own writes, so that the servo never
/// waits for the disk.
class HandRecorder {
 public:
  /// Creates or replaces the first file. Throws std::runtime_error that names the file and the
  /// reason, and std::invalid_argument if the hand is recorded already.
  HandRecorder(const RecordingTarget& target, std::shared_ptr<RecorderPlace> place);
  ~HandRecorder();
  HandRecorder(const HandRecorder&) = delete;
  HandRecorder& operator=(const HandRecorder&) = delete;

  /// Writes a text at this moment. Any thread may call it. Throws std::runtime_error.
  void mark(const std::string& text);
  std::uint64_t ticks() const noexcept { return ticks_.load(); }
  /// Ticks without room: the disk was too slow, or takes no more.
  std::uint64_t lost() const noexcept { return lost_.load(); }
  bool failed() const noexcept { return failed_.load(); }
  /// Writes the rest, and waits until it is on the disk. Returns what is wrong with the recording;
  /// empty: it is complete.
  std::string end() noexcept;

 private:
  friend class RecorderPlace;
  void add(const TickRecord& tick) noexcept;
  void write_until(const std::stop_token& end);
  template <class Action>
  void attempt(Action action) noexcept;

  static constexpr std::size_t kRoom = 1 << 14;  // ticks: 16 s at 1 kHz
  std::shared_ptr<RecorderPlace> place_;
  Ring<TickRecord> rows_{kRoom};
  std::atomic<std::uint64_t> ticks_{0}, lost_{0};
  std::atomic<bool> failed_{false};
  std::mutex mutex_;  // guards the next members
  std::unique_ptr<Recorder> recorder_;
  std::string error_;
  std::jthread writer_;  // the last member: it uses the others
};

}  // namespace feltwire
