#include "client/records.hpp"

#include <cstdio>
#include <exception>

namespace feltwire {

Records::Records(const std::optional<std::filesystem::path>& record, bool observes,
                 const std::optional<std::filesystem::path>& view) {
  if (record) recording_ = std::make_unique<RecordingFile>(*record);
  if (observes) onlooker_ = std::make_unique<Onlooker>(view);
}

void Records::write() noexcept {
  try {
    if (recording_ && !failed_) recording_->write(rows_);
    if (onlooker_ && !failed_) onlooker_->look();
  } catch (const std::exception& error) {
    failed_ = true;
    std::fprintf(stderr, "feltwire-client: what happens is written down no more: %s\n",
                 error.what());
  }
}

}  // namespace feltwire
