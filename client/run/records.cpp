#include "client/run/records.hpp"

#include <exception>
#include <new>

#include "core/base/file_error.hpp"
#include "core/base/visible_text.hpp"

namespace feltwire {

template <class Action>
void Records::attempt(bool& failed, Action action) noexcept {
  if (failed) return;
  try {
    action();
  } catch (const std::exception& error) {
    failed = true;
    tell(error.what());
  }
}

Records::Records(const Files& files, std::FILE* errors) : errors_(errors) {
  if (files.recording) recording_ = open_recording(*files.recording);
  if (files.flight) open_flight(files);
  if (recording_ && flight_) copied_ = std::make_unique<Ring<TickRecord>>(kRecordRoom);
  if (!files.observes) return;
  observer_ = std::make_unique<ObserverRecorder>(
      files.view, [this, on_view = files.on_view](double time, const ObservedScene& scene) {
        if (recording_) attempt(recording_failed_, [&] { recording_->see(time, scene); });
        if (on_view) on_view(time, scene);
      });
}

void Records::open_flight(const Files& files) {
  try {
    flight_ = std::make_unique<FlightRecord>(*files.flight, files.servo_period);
  } catch (const FileError& error) {
    if (files.flight->required) throw;
    tell((std::string("warning: no flight recorder: ") + error.what()).c_str());
  }
}

/// Prints an error. Missing memory must not end the run, because the hand may hold a force.
void Records::tell(const char* what) const noexcept {
  try {
    std::fprintf(errors_, "feltwire-client: %s\n", visible(what).c_str());
  } catch (const std::bad_alloc&) {
    std::fputs("feltwire-client: a file can be written no more, and memory is short\n", errors_);
  }
}

void Records::write_rows() noexcept {
  if (!flight_) return attempt(recording_failed_, [&] { recording_->write(rows_); });
  TickRecord row;
  while (rows_.pop(row)) {
    flight_->add(row);
    if (copied_ && !recording_failed_ && !copied_->push(row)) {
      attempt(recording_failed_, [&] { recording_->write(*copied_); });
      copied_->push(row);
    }
  }
  if (copied_) attempt(recording_failed_, [&] { recording_->write(*copied_); });
}

std::optional<std::filesystem::path> Records::write_flight_record(
    const std::string& cause) noexcept {
  if (!flight_) return std::nullopt;
  try {
    auto file = flight_->write(cause);
    if (file) flight_records_.push_back({*file, cause});
    return file;
  } catch (const std::exception& error) {
    tell(error.what());
    return std::nullopt;
  }
}

void Records::tell_of_flight_record(const std::string& cause) noexcept {
  if (const auto file = write_flight_record(cause))
    std::fprintf(errors_, "feltwire-client: %s; flight record: %s\n", cause.c_str(), file->c_str());
}

void Records::write_due_flight_record() noexcept {
  std::string cause;
  try {
    cause = flight_->cause();
  } catch (const std::bad_alloc&) {
    return;  // the record stays due until memory is free
  }
  if (!cause.empty()) tell_of_flight_record(cause);
}

void Records::write() noexcept {
  if (recording_ || flight_) write_rows();
  if (flight_) write_due_flight_record();
  if (observer_) attempt(view_failed_, [&] { observer_->look(); });
}

void Records::note(const std::map<std::string, std::string>& values) noexcept {
  if (recording_) attempt(recording_failed_, [&] { recording_->note(values); });
  if (flight_) try {
      flight_->note(values);
    } catch (const std::bad_alloc&) {  // without memory the file lacks this entry
    }
}

void Records::finish() noexcept {
  write();
  if (recording_) attempt(recording_failed_, [&] { recording_->finish(); });
  if (observer_) attempt(view_failed_, [&] { observer_->finish(); });
}

}  // namespace feltwire
