#pragma once

#include <array>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "server/fleet/directory.hpp"
#include "tests/server/fleet/write_history.hpp"

namespace feltwire::test {

/// Stands in front of any directory and lies about it: it loses its last writes, answers stale,
/// late, twice or not at all. All hosts of a test share one. It has revisions of its own, since
/// those of the directory behind it never run back.
class LyingDirectory final : public Directory {
 public:
  explicit LyingDirectory(Directory& truth) : truth_(truth) {}

  /// Forgets the last acknowledged writes of a bucket, silently.
  void lose(Bucket bucket, std::size_t writes);
  /// list() answers as it was this many writes ago; 0: with the present.
  void be_stale(std::size_t writes_ago);
  /// Watches show nothing while it holds back, and everything afterwards.
  void hold_back(bool held);
  /// Each watch shows all writes of the bucket once more, also those that were lost.
  void repeat(Bucket bucket);
  /// Writes are done, but the writer gets no answer.
  void answer_no_writes(bool silent);

  WriteAnswer compare_and_swap(Bucket bucket, const std::string& key, std::string_view value,
                               std::uint64_t expected) override;
  WriteAnswer put(Bucket bucket, const std::string& key, std::string_view value) override;
  std::optional<std::vector<DirectoryEntry>> list(Bucket bucket) override;
  std::unique_ptr<DirectoryWatch> watch(Bucket bucket) override;

 private:
  friend class LyingWatch;
  using History = WriteHistory<std::string>;

  struct Contents {
    History history;
    std::map<std::string, std::uint64_t> true_revisions;       // newest of each key
    std::map<std::uint64_t, DirectoryEntry> by_true_revision;  // with our revision
    std::vector<std::deque<DirectoryEntry>*> watchers;         // what each must show next
  };
  Contents& contents(Bucket bucket) { return contents_[static_cast<std::size_t>(bucket)]; }
  WriteAnswer record(Contents& all, const std::string& key, std::string_view value,
                     const WriteAnswer& truth);

  Directory& truth_;
  std::mutex mutex_;
  std::array<Contents, kBucketCount> contents_;  // by Bucket
  std::size_t writes_ago_ = 0;
  bool held_ = false, silent_ = false;
};

}  // namespace feltwire::test
