#include "server/fleet/memory_directory.hpp"

namespace feltwire {

/// Finds the entries behind the revision that it has seen last, so it keeps no queue.
class MemoryWatch final : public DirectoryWatch {
 public:
  MemoryWatch(MemoryDirectory& directory, MemoryDirectory::Contents& contents)
      : directory_(directory), contents_(contents) {}

  std::optional<DirectoryEntry> next(Nanoseconds patience) override {
    std::unique_lock lock(directory_.mutex_);
    const auto changed = [&] { return contents_.last_revision > seen_; };
    if (!directory_.written_.wait_for(lock, patience, changed)) return std::nullopt;
    const auto& [revision, key] = *contents_.keys.upper_bound(seen_);
    seen_ = revision;
    return contents_.entries.find(key)->second;
  }

 private:
  MemoryDirectory& directory_;
  MemoryDirectory::Contents& contents_;
  std::uint64_t seen_ = 0;
};

WriteAnswer MemoryDirectory::write(Contents& contents, const std::string& key,
                                   std::string_view value) {
  DirectoryEntry& entry = contents.entries[key];
  contents.keys.erase(entry.revision);
  entry = {key, std::string(value), ++contents.last_revision};
  contents.keys.emplace(entry.revision, key);
  return {WriteResult::written, entry.revision};
}

WriteAnswer MemoryDirectory::compare_and_swap(Bucket bucket, const std::string& key,
                                              std::string_view value, std::uint64_t expected) {
  const std::lock_guard lock(mutex_);
  Contents& all = contents(bucket);
  const auto found = all.entries.find(key);
  const std::uint64_t present = found != all.entries.end() ? found->second.revision : 0;
  if (present != expected) return {WriteResult::conflict, 0};
  written_.notify_all();
  return write(all, key, value);
}

WriteAnswer MemoryDirectory::put(Bucket bucket, const std::string& key, std::string_view value) {
  const std::lock_guard lock(mutex_);
  written_.notify_all();
  return write(contents(bucket), key, value);
}

std::optional<std::vector<DirectoryEntry>> MemoryDirectory::list(Bucket bucket) {
  const std::lock_guard lock(mutex_);
  std::vector<DirectoryEntry> entries;
  for (const auto& [key, entry] : contents(bucket).entries) entries.push_back(entry);
  return entries;
}

std::unique_ptr<DirectoryWatch> MemoryDirectory::watch(Bucket bucket) {
  return std::make_unique<MemoryWatch>(*this, contents(bucket));
}

}  // namespace feltwire
