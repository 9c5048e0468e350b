#pragma once

#include <array>
#include <condition_variable>
#include <map>
#include <mutex>

#include "server/fleet/directory.hpp"

namespace feltwire {

/// The directory of the hosts in one process. It needs nothing to be installed, loses nothing and
/// always answers at once.
class MemoryDirectory final : public Directory {
 public:
  WriteAnswer compare_and_swap(Bucket bucket, const std::string& key, std::string_view value,
                               std::uint64_t expected) override;
  WriteAnswer put(Bucket bucket, const std::string& key, std::string_view value) override;
  std::optional<std::vector<DirectoryEntry>> list(Bucket bucket) override;
  std::unique_ptr<DirectoryWatch> watch(Bucket bucket) override;

 private:
  friend class MemoryWatch;

  struct Contents {
    std::map<std::string, DirectoryEntry> entries;  // by key
    std::map<std::uint64_t, std::string> keys;      // by revision
    std::uint64_t last_revision = 0;
  };
  static WriteAnswer write(Contents& contents, const std::string& key, std::string_view value);
  Contents& contents(Bucket bucket) { return contents_[static_cast<std::size_t>(bucket)]; }

  std::mutex mutex_;
  std::condition_variable written_;
  std::array<Contents, kBucketCount> contents_;  // by Bucket
};

}  // namespace feltwire
