#pragma once
// A bucket that forgets: the part of a lying directory that is a value, so that a search can copy
// it.

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "server/fleet/directory.hpp"

namespace feltwire::test {

/// All writes of one bucket, also those that it has lost.
template <class Value>
class WriteHistory {
 public:
  struct Write {
    std::string key;
    Value value;
    std::uint64_t revision = 0;

    friend bool operator==(const Write&, const Write&) = default;
  };

  WriteAnswer compare_and_swap(const std::string& key, Value value, std::uint64_t expected) {
    const Write* const found = current(key);
    if ((found != nullptr ? found->revision : 0) != expected) return {WriteResult::conflict, 0};
    return put(key, std::move(value));
  }

  WriteAnswer put(const std::string& key, Value value) {
    log_.push_back({key, std::move(value), log_.size() + 1});
    ever_.push_back(log_.back());
    return {WriteResult::written, log_.back().revision};
  }

  /// Loses the last writes. The next ones get their revisions again.
  void lose(std::size_t writes) { log_.resize(log_.size() - std::min(writes, log_.size())); }

  /// Null: there is no such key.
  const Write* current(const std::string& key) const {
    const auto found = std::find_if(log_.rbegin(), log_.rend(),
                                    [&](const Write& write) { return write.key == key; });
    return found != log_.rend() ? &*found : nullptr;
  }

  /// The newest write of each key, by revision, as it was this many writes ago.
  std::vector<Write> entries(std::size_t ago = 0) const {
    std::vector<Write> newest;
    for (std::size_t i = 0; i + ago < log_.size(); ++i) {
      std::erase_if(newest, [&](const Write& write) { return write.key == log_[i].key; });
      newest.push_back(log_[i]);
    }
    return newest;
  }

  const std::vector<Write>& log() const { return log_; }
  /// In the order of writing.
  const std::vector<Write>& ever() const { return ever_; }

 private:
  std::vector<Write> log_, ever_;
};

}  // namespace feltwire::test
