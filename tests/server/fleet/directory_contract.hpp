#pragma once
// Tests of what every Directory does, whichever way it stores.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>

#include "server/fleet/directory.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::test {

/// Writes until the directory answers. A cluster that is choosing a leader answers nobody.
inline WriteAnswer answered_put(Directory& directory, Bucket bucket, const std::string& key,
                                const std::string& value) {
  WriteAnswer answer;
  eventually("an answer to a write", [&] {
    answer = directory.put(bucket, key, value);
    return answer.result == WriteResult::written;
  });
  return answer;
}

/// Reads a watch until the key has the value, and returns that entry.
inline DirectoryEntry await_value(DirectoryWatch& watch, const std::string& key,
                                  const std::string& value) {
  DirectoryEntry found;
  eventually("the watch shows " + key, [&] {
    const auto entry = watch.next(std::chrono::milliseconds(50));
    if (!entry || entry->key != key || entry->value != value) return false;
    found = *entry;
    return true;
  });
  return found;
}

inline void expect_compare_and_swap(Directory& directory) {
  const auto swap = [&](const std::string& value, std::uint64_t expected) {
    WriteAnswer answer;
    eventually("an answer to a compare-and-swap", [&] {
      answer = directory.compare_and_swap(Bucket::scenes, "swapped room", value, expected);
      return answer.result != WriteResult::unknown;
    });
    return answer;
  };
  const WriteAnswer first = swap("one", 0);
  ASSERT_EQ(first.result, WriteResult::written);
  EXPECT_GT(first.revision, 0u);
  EXPECT_EQ(swap("two", 0).result, WriteResult::conflict) << "there is one already";
  EXPECT_EQ(swap("two", first.revision + 1).result, WriteResult::conflict);
  const WriteAnswer second = swap("two", first.revision);
  ASSERT_EQ(second.result, WriteResult::written);
  EXPECT_GT(second.revision, first.revision);
  EXPECT_EQ(swap("three", first.revision).result, WriteResult::conflict) << "an old revision";
  const auto watch = directory.watch(Bucket::scenes);
  const DirectoryEntry seen = await_value(*watch, "swapped room", "two");
  EXPECT_EQ(seen.revision, second.revision);
}

inline void expect_watch(Directory& directory) {
  const std::string bytes("\0\xff\n= *>", 8);  // a value is any bytes
  answered_put(directory, Bucket::hosts, "before", bytes);
  const auto watch = directory.watch(Bucket::hosts);
  await_value(*watch, "before", bytes);
  const WriteAnswer after = answered_put(directory, Bucket::hosts, "a.b/\xc3\xa4 *", "1");
  EXPECT_EQ(await_value(*watch, "a.b/\xc3\xa4 *", "1").revision, after.revision);
  answered_put(directory, Bucket::hosts, "before", "2");
  await_value(*watch, "before", "2");

  std::map<std::string, std::string> listed;
  eventually("the list has the newest values", [&] {
    const auto entries = directory.list(Bucket::hosts);
    if (!entries) return false;
    listed.clear();
    for (const DirectoryEntry& entry : *entries) listed[entry.key] = entry.value;
    return listed["before"] == "2";
  });
  EXPECT_EQ(listed, (std::map<std::string, std::string>{{"a.b/\xc3\xa4 *", "1"}, {"before", "2"}}));
}

}  // namespace feltwire::test
