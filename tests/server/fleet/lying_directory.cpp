#include "tests/server/fleet/lying_directory.hpp"

#include <algorithm>

namespace feltwire::test {

class LyingWatch final : public DirectoryWatch {
 public:
  LyingWatch(LyingDirectory& directory, LyingDirectory::Contents& all,
             std::unique_ptr<DirectoryWatch> truth)
      : directory_(directory), all_(all), truth_(std::move(truth)) {
    const std::lock_guard lock(directory_.mutex_);
    for (const auto& write : all_.history.entries())
      next_.push_back({write.key, write.value, write.revision});
    if (!all_.by_true_revision.empty()) shown_ = all_.by_true_revision.rbegin()->first;
    all_.watchers.push_back(&next_);
  }
  ~LyingWatch() override {
    const std::lock_guard lock(directory_.mutex_);
    std::erase(all_.watchers, &next_);
  }

  std::optional<DirectoryEntry> next(Nanoseconds patience) override {
    const auto ready = [&]() -> std::optional<DirectoryEntry> {
      if (directory_.held_ || next_.empty()) return std::nullopt;
      DirectoryEntry entry = std::move(next_.front());
      next_.pop_front();
      return entry;
    };
    {
      const std::lock_guard lock(directory_.mutex_);
      if (auto entry = ready()) return entry;
      if (directory_.held_) return std::nullopt;
    }
    const auto entry = truth_->next(patience);
    const std::lock_guard lock(directory_.mutex_);
    if (entry && entry->revision > shown_) {
      shown_ = entry->revision;
      const auto known = all_.by_true_revision.find(entry->revision);
      // A write whose answer was lost, or of a host that does not use this directory.
      if (known == all_.by_true_revision.end())
        directory_.record(all_, entry->key, entry->value, {WriteResult::written, entry->revision});
      next_.push_back(all_.by_true_revision.at(entry->revision));
    }
    return ready();
  }

 private:
  LyingDirectory& directory_;
  LyingDirectory::Contents& all_;
  std::unique_ptr<DirectoryWatch> truth_;
  std::deque<DirectoryEntry> next_;
  std::uint64_t shown_ = 0;  // of the truth's revisions
};

void LyingDirectory::lose(Bucket bucket, std::size_t writes) {
  const std::lock_guard lock(mutex_);
  contents(bucket).history.lose(writes);
}

void LyingDirectory::be_stale(std::size_t writes_ago) {
  const std::lock_guard lock(mutex_);
  writes_ago_ = writes_ago;
}

void LyingDirectory::hold_back(bool held) {
  const std::lock_guard lock(mutex_);
  held_ = held;
}

void LyingDirectory::repeat(Bucket bucket) {
  const std::lock_guard lock(mutex_);
  Contents& all = contents(bucket);
  for (auto* const watcher : all.watchers)
    for (const auto& write : all.history.ever())
      watcher->push_back({write.key, write.value, write.revision});
}

void LyingDirectory::answer_no_writes(bool silent) {
  const std::lock_guard lock(mutex_);
  silent_ = silent;
}

WriteAnswer LyingDirectory::record(Contents& all, const std::string& key, std::string_view value,
                                   const WriteAnswer& truth) {
  if (truth.result != WriteResult::written) return truth;
  const WriteAnswer answer = all.history.put(key, std::string(value));
  std::uint64_t& newest = all.true_revisions[key];
  newest = std::max(newest, truth.revision);
  all.by_true_revision[truth.revision] = {key, std::string(value), answer.revision};
  return silent_ ? WriteAnswer{} : answer;
}

WriteAnswer LyingDirectory::compare_and_swap(Bucket bucket, const std::string& key,
                                             std::string_view value, std::uint64_t expected) {
  const std::lock_guard lock(mutex_);
  Contents& all = contents(bucket);
  const auto* const present = all.history.current(key);
  if ((present != nullptr ? present->revision : 0) != expected) return {WriteResult::conflict, 0};
  const auto known = all.true_revisions.find(key);
  const std::uint64_t true_revision = known != all.true_revisions.end() ? known->second : 0;
  return record(all, key, value, truth_.compare_and_swap(bucket, key, value, true_revision));
}

WriteAnswer LyingDirectory::put(Bucket bucket, const std::string& key, std::string_view value) {
  const std::lock_guard lock(mutex_);
  return record(contents(bucket), key, value, truth_.put(bucket, key, value));
}

std::optional<std::vector<DirectoryEntry>> LyingDirectory::list(Bucket bucket) {
  const std::lock_guard lock(mutex_);
  std::vector<DirectoryEntry> entries;
  for (const auto& write : contents(bucket).history.entries(writes_ago_))
    entries.push_back({write.key, write.value, write.revision});
  std::ranges::sort(entries, {}, &DirectoryEntry::key);
  return entries;
}

std::unique_ptr<DirectoryWatch> LyingDirectory::watch(Bucket bucket) {
  return std::make_unique<LyingWatch>(*this, contents(bucket), truth_.watch(bucket));
}

}  // namespace feltwire::test
