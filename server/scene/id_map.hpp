#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace feltwire {

/// Maps session ids to values in one flat array: open addressing, linear probing, at most half
/// full. Ids come from the operating system's random source, so their own bits are the hash; 0 is
/// not an id. Allocates only when it is constructed.
template <class Value>
class IdMap {
 public:
  explicit IdMap(std::size_t capacity)
      : entries_(std::bit_ceil(2 * (capacity + 1))), mask_(entries_.size() - 1) {}

  /// Null if there is none.
  Value* find(std::uint64_t id) noexcept {
    if (id == 0) return nullptr;
    for (std::size_t i = home(id); entries_[i].id != 0; i = next(i))
      if (entries_[i].id == id) return &entries_[i].value;
    return nullptr;
  }

  /// False if the id is 0 or already used, or the capacity is used up.
  bool insert(std::uint64_t id, Value value) noexcept {
    if (id == 0 || 2 * (size_ + 1) > entries_.size()) return false;
    std::size_t i = home(id);
    for (; entries_[i].id != 0; i = next(i))
      if (entries_[i].id == id) return false;
    entries_[i] = {id, value};
    ++size_;
    return true;
  }

  bool erase(std::uint64_t id) noexcept {
    if (id == 0) return false;
    std::size_t hole = home(id);
    while (entries_[hole].id != id) {
      if (entries_[hole].id == 0) return false;
      hole = next(hole);
    }
    // Entries behind the hole move up if their own place allows it, so that no probe ends early.
    for (std::size_t i = next(hole); entries_[i].id != 0; i = next(i)) {
      if (((i - home(entries_[i].id)) & mask_) >= ((i - hole) & mask_)) {
        entries_[hole] = entries_[i];
        hole = i;
      }
    }
    entries_[hole] = {};
    --size_;
    return true;
  }

  std::size_t size() const { return size_; }

 private:
  struct Entry {
    std::uint64_t id = 0;
    Value value{};
  };
  // The low byte names the scene and is the same for all ids of one host.
  std::size_t home(std::uint64_t id) const { return static_cast<std::size_t>(id >> 8) & mask_; }
  std::size_t next(std::size_t i) const { return (i + 1) & mask_; }

  std::vector<Entry> entries_;
  std::size_t mask_;
  std::size_t size_ = 0;
};

}  // namespace feltwire
