#include "client/run/records.hpp"

#include <exception>
#include <new>

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
  if (!files.observes) return;
  observer_ = std::make_unique<ObserverRecorder>(
      files.view, [this, on_view = files.on_view](double time, const ObservedScene& scene) {
        if (recording_) attempt(recording_failed_, [&] { recording_->see(time, scene); });
        if (on_view) on_view(time, scene);
      });
}

/// A hand may hold a force meanwhile: that there is no memory to say it nicely ends nothing.
void Records::tell(const char* what) const noexcept {
  try {
    std::fprintf(errors_, "feltwire-client: %s\n", visible(what).c_str());
  } catch (const std::bad_alloc&) {
    std::fputs("feltwire-client: a file can be written no more, and memory is short\n", errors_);
  }
}

void Records::write() noexcept {
  if (recording_) attempt(recording_failed_, [&] { recording_->write(rows_); });
  if (observer_) attempt(view_failed_, [&] { observer_->look(); });
}

void Records::finish() noexcept {
  write();
  if (recording_) attempt(recording_failed_, [&] { recording_->finish(); });
  if (observer_) attempt(view_failed_, [&] { observer_->finish(); });
}

}  // namespace feltwire
