#pragma once
// What is written down while a run goes on.

#include <filesystem>
#include <memory>
#include <optional>

#include "client/onlooker.hpp"
#include "client/recording.hpp"

namespace feltwire {

/// The rows of --record, and an observer's views with --view. Writing that fails is said once, and
/// ends the writing, not the run.
class Records {
 public:
  /// `observes`: what is seen is counted, and written to `view` where there is one. Throws
  /// std::runtime_error naming the file.
  Records(const std::optional<std::filesystem::path>& record, bool observes,
          const std::optional<std::filesystem::path>& view);

  Ring<TickRecord>* rows() { return recording_ ? &rows_ : nullptr; }
  Ring<TimedView>* views() { return onlooker_ ? &onlooker_->views() : nullptr; }
  std::optional<SightCounts> sight() const {
    return onlooker_ ? std::optional(onlooker_->counts()) : std::nullopt;
  }
  /// Takes what waits.
  void write() noexcept;
  bool failed() const { return failed_; }

 private:
  static constexpr std::size_t kRoom = 1 << 14;  // rows: more than a second at 10 kHz
  std::unique_ptr<RecordingFile> recording_;
  Ring<TickRecord> rows_{kRoom};
  std::unique_ptr<Onlooker> onlooker_;
  bool failed_ = false;
};

}  // namespace feltwire
