#include "client/c_api/hand_recorder.hpp"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <stdexcept>
#include <utility>

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kBetweenRows{50};  // two writes

[[noreturn]] void refuse_second() {
  throw std::invalid_argument("the hand is recorded already; close its recorder first");
}

/// Opens no file for a hand that is recorded already.
std::unique_ptr<Recorder> opened(const RecordingTarget& target, const RecorderPlace& place) {
  if (!place.is_free()) refuse_second();
  return open_recording(target);
}

}  // namespace

void RecorderPlace::add(const TickRecord& tick) noexcept {
  // leave() sees that it is in use, or this thread sees that there is no recorder.
  in_use_.store(true);
  if (HandRecorder* recorder = recorder_.load()) recorder->add(tick);
  in_use_.store(false);
}

bool RecorderPlace::take(HandRecorder& recorder) noexcept {
  HandRecorder* none = nullptr;
  return recorder_.compare_exchange_strong(none, &recorder);
}

void RecorderPlace::leave() noexcept {
  recorder_.store(nullptr);
  while (in_use_.load()) std::this_thread::yield();
}

HandRecorder::HandRecorder(const RecordingTarget& target, std::shared_ptr<RecorderPlace> place)
    : place_(std::move(place)), recorder_(opened(target, *place_)) {
  writer_ = std::jthread([this](const std::stop_token& end) { write_until(end); });
  if (!place_->take(*this)) {
    place_.reset();
    refuse_second();
  }
}

HandRecorder::~HandRecorder() { end(); }

void HandRecorder::add(const TickRecord& tick) noexcept {
  const bool has_room = !failed_.load() && rows_.push(tick);
  (has_room ? ticks_ : lost_).fetch_add(1);
}

template <class Action>
void HandRecorder::attempt(Action action) noexcept {
  const std::lock_guard lock(mutex_);
  if (failed_.load()) return;
  try {
    action();
  } catch (const std::exception& error) {
    failed_.store(true);
    try {
      error_ = error.what();
    } catch (const std::bad_alloc&) {  // end() has a text for it
    }
  }
}

void HandRecorder::mark(const std::string& text) {
  attempt([&] { recorder_->mark(text); });
  if (failed()) throw std::runtime_error("the recording can be written no more; close it");
}

void HandRecorder::write_until(const std::stop_token& end) {
  std::mutex waiting;
  std::condition_variable_any ended;
  for (std::unique_lock lock(waiting); !end.stop_requested();) {
    ended.wait_for(lock, end, kBetweenRows, [] { return false; });
    attempt([this] { recorder_->write(rows_); });
  }
}

std::string HandRecorder::end() noexcept {
  if (!place_) return {};
  place_->leave();
  place_.reset();
  writer_.request_stop();
  if (writer_.joinable()) writer_.join();
  attempt([this] {
    recorder_->write(rows_);
    recorder_->finish();
  });
  try {
    if (failed()) return error_.empty() ? "there was no memory for the recording" : error_;
    if (lost() > 0)
      return "the recording lacks " + std::to_string(lost()) +
             " ticks, because the disk was too slow; record to a faster one";
  } catch (const std::bad_alloc&) {  // no memory for the text
  }
  return {};
}

}  // namespace feltwire
