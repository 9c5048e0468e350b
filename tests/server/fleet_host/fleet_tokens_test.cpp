// The tokens of a fleet: whatever the directory does, the hosts come to the same tokens, and no
// revocation is undone.

#include "server/fleet_host/fleet_tokens.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "core/base/file_error.hpp"
#include "core/base/pending_file.hpp"
#include "core/base/splitmix.hpp"
#include "server/access/token_file.hpp"
#include "server/app/token_places.hpp"
#include "server/fleet/memory_directory.hpp"
#include "tests/server/fleet/lying_directory.hpp"
#include "tests/support/seeds.hpp"
#include "tests/support/temporary_folder.hpp"

namespace feltwire::fleet_tokens_test {
namespace {

using test::LyingDirectory;
using test::TemporaryFolder;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// Anna's token is good for a day, the others are good for ever.
Token token(const std::string& client = "anna") {
  std::optional<CalendarTime> expires;
  if (client == "anna") expires = calendar_now() + std::chrono::days(1);
  return issue_token(client, "*", Role::operator_, expires).token;
}
DirectoryEntry entry(const Token& token) { return {token.id, encode(token), 1}; }

/// The tokens in the file that are good now.
std::set<std::string> good(const std::filesystem::path& file) {
  std::set<std::string> ids;
  const TokenFile kept(file);
  for (const Token& token : kept.tokens())
    if (!expired(token, calendar_now())) ids.insert(token.id);
  return ids;
}

TEST(FleetTokens, ARevocationCountsInAnyOrder) {
  const TemporaryFolder folder;
  const Token anna = token(), bob = token("bob");
  std::vector<DirectoryEntry> seen = {entry(anna), entry(bob), entry(revoked(anna)), entry(anna)};
  std::ranges::sort(seen, {}, &DirectoryEntry::value);
  do {
    FleetTokens tokens(folder / "tokens.json");
    for (const DirectoryEntry& each : seen) tokens.see(each);
    tokens.save();
    EXPECT_EQ(good(folder / "tokens.json"), std::set{bob.id});
    std::filesystem::remove(folder / "tokens.json");
  } while (std::ranges::next_permutation(seen, {}, &DirectoryEntry::value).found);
}

TEST(FleetTokens, OutliveARestart) {
  const TemporaryFolder folder;
  const Token anna = token(), bob = token("bob");
  {
    FleetTokens tokens(folder / "tokens.json");
    EXPECT_FALSE(tokens.changed());
    tokens.see(entry(anna));
    tokens.see(entry(revoked(bob)));
    EXPECT_TRUE(tokens.changed());
    tokens.save();
    EXPECT_FALSE(tokens.changed());
  }
  FleetTokens tokens(folder / "tokens.json");
  tokens.see(entry(anna));
  tokens.see(entry(bob));  // an old backup of the directory
  EXPECT_FALSE(tokens.changed());
  EXPECT_EQ(good(folder / "tokens.json"), std::set{anna.id});
  replace_file(folder / "tokens.json", "broken", kPrivate);
  EXPECT_THROW(FleetTokens(folder / "tokens.json"), FileError);
}

TEST(FleetTokens, WhatIsNoTokenIsIgnored) {
  const TemporaryFolder folder;
  FleetTokens tokens(folder / "tokens.json");
  const Token anna = token();
  for (const std::string& value : {std::string(), std::string("no JSON"), json({}),
                                   json({anna, token()}), std::string(100'000, '[')})
    tokens.see({anna.id, value, 1});
  tokens.see({"0123456789ab", encode(anna), 1});  // the value of another key
  EXPECT_FALSE(tokens.changed());
}

TEST(FleetTokens, ATokenKeepsItsHolderAndItsSecret) {
  const TemporaryFolder folder;
  FleetTokens tokens(folder / "tokens.json");
  const Token anna = token();
  Token forged = token("eve");
  forged.id = anna.id;
  tokens.see(entry(anna));
  tokens.see(entry(forged));
  tokens.save();
  EXPECT_EQ(TokenFile(folder / "tokens.json").tokens().front().hash, anna.hash);
}

TEST(FleetTokens, TheDirectoryGetsBackWhatItLost) {
  const TemporaryFolder folder;
  MemoryDirectory truth;
  LyingDirectory directory(truth);
  FleetTokens tokens(folder / "tokens.json");
  const auto see = [&] {
    const auto listed = directory.list(Bucket::tokens);
    for (const DirectoryEntry& each : *listed) tokens.see(each);
    return tokens.missing(*listed);
  };
  const Token anna = token();
  const TokenPlace place =
      fleet_of_tokens(std::shared_ptr<Directory>(std::shared_ptr<Directory>(), &directory));
  place.add(anna);
  EXPECT_THAT(see(), IsEmpty());
  EXPECT_TRUE(place.revoke(anna.id));
  EXPECT_TRUE(place.revoke(anna.id));
  EXPECT_FALSE(place.revoke("0123456789ab"));
  EXPECT_THAT(see(), IsEmpty());
  directory.lose(Bucket::tokens, 1);
  EXPECT_FALSE(expired(place.list().front(), calendar_now()));  // the revocation is lost
  const auto once = see();
  ASSERT_THAT(once, SizeIs(1));
  directory.compare_and_swap(Bucket::tokens, once[0].key, once[0].value, once[0].revision);
  EXPECT_TRUE(expired(place.list().front(), calendar_now()));
  directory.lose(Bucket::tokens, 2);
  EXPECT_THAT(place.list(), IsEmpty());
  const auto twice = see();
  ASSERT_THAT(twice, SizeIs(1));
  EXPECT_EQ(twice[0].revision, 0u);
  directory.answer_no_writes(true);
  EXPECT_THROW(place.add(token()), std::runtime_error);
}

/// Three hosts and an operator, and a directory that lies in all its ways. When it lies no more,
/// all hosts have the same tokens, and none that a host has seen revoked is good.
TEST(FleetTokens, HostsAgreeAfterEveryLie) {
  for (const std::uint64_t seed : test::seeds(1, 20, 2)) {
    std::uint64_t draws = 0;
    const auto one_of = [&](std::uint64_t count) { return splitmix::draw(seed, draws++) % count; };
    const TemporaryFolder folder;
    MemoryDirectory truth;
    LyingDirectory directory(truth);
    struct Host {
      std::filesystem::path file;
      FleetTokens tokens;
      std::unique_ptr<DirectoryWatch> watch;
    };
    std::vector<Host> hosts;
    for (const char* name : {"a", "b", "c"})
      hosts.push_back({folder / name, FleetTokens(folder / name), directory.watch(Bucket::tokens)});
    std::vector<Token> issued;
    std::set<std::string> seen_revoked;
    const auto see = [&](Host& host, const DirectoryEntry& each) {
      host.tokens.see(each);
      const auto token = decode_token(each);
      if (token && expired(*token, calendar_now())) seen_revoked.insert(token->id);
    };
    const auto read = [&](Host& host) {
      while (const auto each = host.watch->next(Nanoseconds(0))) see(host, *each);
    };
    const auto list = [&](Host& host) {
      const auto listed = directory.list(Bucket::tokens);
      for (const DirectoryEntry& each : *listed) see(host, each);
      for (const auto& write : host.tokens.missing(*listed))
        directory.compare_and_swap(Bucket::tokens, write.key, write.value, write.revision);
    };
    const TokenPlace place =
        fleet_of_tokens(std::shared_ptr<Directory>(std::shared_ptr<Directory>(), &directory));
    for (int step = 0; step < 200; ++step) {
      Host& host = hosts[one_of(hosts.size())];
      switch (one_of(9)) {
        case 0:
          issued.push_back(token(one_of(2) == 0 ? "anna" : "bob"));
          try {
            place.add(issued.back());
          } catch (const std::runtime_error&) {  // no answer
          }
          break;
        case 1:
          if (issued.empty()) break;
          try {
            place.revoke(issued[one_of(issued.size())].id);
          } catch (const std::runtime_error&) {  // no answer
          }
          break;
        case 2:
          directory.lose(Bucket::tokens, one_of(4));
          break;
        case 3:
          directory.be_stale(one_of(4));
          break;
        case 4:
          directory.hold_back(one_of(2) == 0);
          break;
        case 5:
          directory.repeat(Bucket::tokens);
          break;
        case 6:
          directory.answer_no_writes(one_of(2) == 0);
          break;
        case 7:
          read(host);
          break;
        default:
          list(host);
      }
    }
    directory.be_stale(0);
    directory.hold_back(false);
    directory.answer_no_writes(false);
    for (int round = 0; round < 2; ++round)
      for (Host& host : hosts) {
        read(host);
        list(host);
      }
    for (Host& host : hosts) {
      host.tokens.save();
      EXPECT_EQ(good(host.file), good(hosts.front().file));
      for (const std::string& id : good(host.file)) EXPECT_FALSE(seen_revoked.contains(id));
    }
    EXPECT_THAT(issued, Not(IsEmpty()));
  }
}

}  // namespace
}  // namespace feltwire::fleet_tokens_test
