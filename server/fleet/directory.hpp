#pragma once
// The directory of a fleet: four buckets of small values that all hosts watch.
//
// It decides nothing. A directory may lose what it has acknowledged and may answer late or twice;
// the rules of ownership.hpp hold with all of that. So there is no get: a read after a write need
// not see it. A host writes by compare-and-swap, and learns from a watch what became of it.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.hpp"

namespace feltwire {

enum class Bucket {
  hosts,   // by the host's name, its heartbeat; only this host writes it
  scenes,  // by the scene's name, its record; hosts write it
  wishes,  // by the host's name, a wish to it; only `feltwire-server fleet` writes it
  tokens,  // by the token's id, what a host keeps of it; `feltwire-server token` and hosts write it
};
inline constexpr std::size_t kBucketCount = 4;

/// The newest value of a key.
struct DirectoryEntry {
  std::string key, value;
  std::uint64_t revision = 0;  // from 1, rising within a bucket; runs back if writes were lost

  friend bool operator==(const DirectoryEntry&, const DirectoryEntry&) = default;
};

enum class WriteResult {
  written,
  conflict,  // the key has another revision; nothing was written
  unknown,   // no answer came in time; it may be written or not, or still be written later
};

struct WriteAnswer {
  WriteResult result = WriteResult::unknown;
  std::uint64_t revision = 0;  // of the new entry, if it is written

  friend bool operator==(const WriteAnswer&, const WriteAnswer&) = default;
};

/// A look at a bucket. One thread uses it.
class DirectoryWatch {
 public:
  virtual ~DirectoryWatch() = default;

  /// The next entry: first every entry that is there, then each change. Of several changes of a
  /// key the last is enough. Waits for it; empty if none came within `patience`.
  virtual std::optional<DirectoryEntry> next(Nanoseconds patience) = 0;
};

/// Calls may come from any thread and may block, up to a time limit that the implementation names.
/// No call is on the path of a sample or of a join.
class Directory {
 public:
  virtual ~Directory() = default;

  /// Writes the value if the key's revision is `expected`; 0: if there is no such key.
  virtual WriteAnswer compare_and_swap(Bucket bucket, const std::string& key,
                                       std::string_view value, std::uint64_t expected) = 0;

  /// Writes the value in any case, for a key that only one host writes: its heartbeat.
  virtual WriteAnswer put(Bucket bucket, const std::string& key, std::string_view value) = 0;

  /// All entries of a bucket, by key; empty: no answer came in time. A host lists again from time
  /// to time, as a watch may miss a change.
  virtual std::optional<std::vector<DirectoryEntry>> list(Bucket bucket) = 0;

  /// The watch must not outlive the directory. Throws std::runtime_error.
  virtual std::unique_ptr<DirectoryWatch> watch(Bucket bucket) = 0;
};

}  // namespace feltwire
