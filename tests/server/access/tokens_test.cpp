// Tests tokens: their texts, their files, and concurrent writers.

#include "server/access/tokens.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <thread>

#include "core/base/json_document.hpp"
#include "core/base/pending_file.hpp"
#include "server/access/security.hpp"
#include "server/app/server_config.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::tokens_test {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::text_of;

const CalendarTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 21) + 17h;

IssuedToken issue(std::optional<CalendarTime> expires = std::nullopt) {
  return issue_token("anna", "room", Role::operator_, expires);
}

TEST(Tokens, OneIsKnownByItsTextAlone) {
  const IssuedToken anna = issue(), berta = issue();
  const Tokens tokens = {anna.token, berta.token};
  const std::string text(anna.text.text());
  EXPECT_THAT(text, ::testing::MatchesRegex("fw_[0-9a-f]+_[A-Za-z0-9_-]+"));
  EXPECT_EQ(authenticate(tokens, text, kNow), &tokens[0]);
  EXPECT_EQ(authenticate(tokens, berta.text.text(), kNow), &tokens[1]);
  EXPECT_EQ(authenticate({berta.token}, text, kNow), nullptr);
  EXPECT_EQ(authenticate({}, text, kNow), nullptr);
  // The stored text must differ from the token text.
  EXPECT_THAT(json(tokens), ::testing::Not(HasSubstr(text.substr(text.size() - 43))));
}

TEST(Tokens, NoOtherTextIsOne) {
  const IssuedToken anna = issue(), berta = issue();
  const Tokens tokens = {anna.token, berta.token};
  const std::string text(anna.text.text()), other(berta.text.text());
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string spoiled = text;
    spoiled[i] = spoiled[i] == 'x' ? 'y' : 'x';
    // The last of 43 digits contains four bits of the secret and two zero bits.
    EXPECT_EQ(authenticate(tokens, spoiled, kNow), nullptr) << i;
    EXPECT_EQ(authenticate(tokens, text.substr(0, i), kNow), nullptr) << i;
  }
  for (const std::string& wrong : {text + "A", text + "=", " " + text, std::string(),
                                   std::string("fw_"), text.substr(0, 16) + other.substr(16)})
    EXPECT_EQ(authenticate(tokens, wrong, kNow), nullptr) << wrong;
}

TEST(Tokens, OneExpires) {
  const IssuedToken anna = issue(kNow + 1s);
  const Tokens tokens = {anna.token};
  EXPECT_NE(authenticate(tokens, anna.text.text(), kNow), nullptr);
  EXPECT_EQ(authenticate(tokens, anna.text.text(), kNow + 1s), nullptr);
}

TEST(Tokens, ExpiryAsWritten) {
  EXPECT_EQ(parse_expiry("30d", kNow), kNow + 30 * 24h);
  EXPECT_EQ(parse_expiry("12h", kNow), kNow + 12h);
  EXPECT_EQ(parse_expiry("never", kNow), std::nullopt);
  // A date is valid until its end.
  EXPECT_EQ(expiry_text(parse_expiry("2026-12-31", kNow)), "2027-01-01 00:00:00 UTC");
  EXPECT_EQ(parse_expiry("2026-11-21", kNow), kNow + 7h);
  EXPECT_EQ(expiry_text(std::nullopt), "never");
  for (const char* wrong : {"", "d", "0d", "-1d", "1.5d", "30", "2026-11-20", "2026-02-30",
                            "2026-1-01", "tomorrow", "99999999d", "30d "})
    EXPECT_THAT(error_of<std::invalid_argument>([&] { parse_expiry(wrong, kNow); }),
                HasSubstr("is no time to expire"))
        << wrong;
}

TEST(Tokens, RolesCoverWhatStandsBelow) {
  EXPECT_TRUE(covers(Role::admin, Role::operator_) && covers(Role::operator_, Role::observer) &&
              covers(Role::observer, Role::observer));
  EXPECT_FALSE(covers(Role::observer, Role::operator_) || covers(Role::operator_, Role::admin));
  EXPECT_TRUE(covers(Role::operator_, Role::pointer) && covers(Role::pointer, Role::observer));
  EXPECT_FALSE(covers(Role::observer, Role::pointer) || covers(Role::pointer, Role::operator_));
  EXPECT_EQ(role("operator"), Role::operator_);
  EXPECT_THAT(error_of<std::invalid_argument>([] { role("king"); }), HasSubstr("observer"));
}

TEST(Tokens, SurviveTheFile) {
  const Tokens tokens = {
      issue(kNow).token,
      issue_token("b \"q\" \\ \xc3\xa4", "*", Role::admin, std::nullopt, 0.3).token,
      issue_token("cell", "room", Role::follower, std::nullopt, 0.0, "left \"arm\"").token};
  const Tokens read = parse_tokens(json(tokens), "t.json");
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[2].seat, "left \"arm\"");
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].seat, tokens[i].seat);
    EXPECT_EQ(read[i].id, tokens[i].id);
    EXPECT_EQ(read[i].client, tokens[i].client);
    EXPECT_EQ(read[i].scene, tokens[i].scene);
    EXPECT_EQ(read[i].role, tokens[i].role);
    EXPECT_EQ(read[i].lead_share, tokens[i].lead_share);
    EXPECT_EQ(read[i].expires, tokens[i].expires);
    EXPECT_EQ(read[i].salt, tokens[i].salt);
    EXPECT_EQ(read[i].hash, tokens[i].hash);
  }
  EXPECT_THROW(issue_token("", "*", Role::admin, std::nullopt), std::invalid_argument);
  EXPECT_THROW(issue_token("a\nb", "*", Role::admin, std::nullopt), std::invalid_argument);
  EXPECT_THROW(issue_token("a", std::string(129, 'x'), Role::admin, std::nullopt),
               std::invalid_argument);
  for (const double share : {-1.0, 0.001, 101.0, std::nan("")})
    EXPECT_THROW(issue_token("a", "*", Role::operator_, std::nullopt, share),
                 std::invalid_argument);
  EXPECT_THROW(issue_token("a", "*", Role::observer, std::nullopt, 1.0), std::invalid_argument);
  EXPECT_THAT(error_of<std::invalid_argument>(
                  [] { issue_token("a", "b", Role::operator_, std::nullopt, 0.0, "left"); }),
              HasSubstr("the seat's name is for tokens of the role follower"));
  EXPECT_THROW(issue_token("a", "b", Role::follower, std::nullopt, 0.0, "le\nft"),
               std::invalid_argument);
}

TEST(Tokens, BadFilesNameLineAndField) {
  const std::string good = json({issue().token});
  ASSERT_NO_THROW(parse_tokens(good, "t.json"));
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::string twice = [] {
    const Token token = issue().token;
    return json({token, token});
  }();
  const std::vector<std::pair<std::string, std::string>> faults = {
      {"{}", "tokens"},
      {"", ""},
      {good.substr(0, good.size() / 2), ""},
      {replaced("\"id\": \"", "\"id\": \"X"), "tokens[0].id"},
      {replaced("\"anna\"", "\"\""), "tokens[0].client"},
      {replaced("\"room\"", "7"), "tokens[0].scene"},
      {replaced("\"operator\"", "\"king\""), "tokens[0].role"},
      {replaced("\"expires\": 0", "\"expires\": -1"), "tokens[0].expires"},
      {replaced("\"expires\": 0", "\"expires\": 9e9"), "tokens[0].expires"},
      {replaced("\"salt\": \"", "\"salt\": \"0"), "tokens[0].salt"},
      {replaced("\"hash\": \"", "\"hash\": \"g"), "tokens[0].hash"},
      {replaced("\"role\"", "\"rule\""), "rule"},
      {replaced("\"hash\"", "\"seat\": \"left\", \"hash\""), "tokens[0].seat"},
      {twice, "tokens[1].id"},
  };
  for (const auto& [text, field] : faults)
    EXPECT_THAT(error_of<FileError>([&, &bad = text] { parse_tokens(bad, "t.json"); }),
                AllOf(::testing::StartsWith("t.json:"), HasSubstr(field)))
        << text;
}

/// Two writers work at once, many times. No change may be lost, and a reader must see only complete
/// files.
TEST(TokenFile, WritersLoseNothing) {
  const TemporaryFolder folder;
  const auto path = folder / "tokens.json";
  change_tokens(path, [](Tokens&) {});
  constexpr int kEach = 20;
  const auto write = [&] {
    for (int i = 0; i < kEach; ++i)
      change_tokens(path, [](Tokens& tokens) { tokens.push_back(issue().token); });
  };
  std::thread first(write), second(write);
  TokenFile reader(path);
  while (reader.tokens().size() < 2 * kEach) EXPECT_EQ(reader.refresh(), std::nullopt);
  first.join();
  second.join();
  EXPECT_EQ(TokenFile(path).tokens().size(), 2u * kEach);
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, kPrivate);
  EXPECT_EQ(folder.entries(), 2u);  // The folder has the file and its lock, but no temporary file.
}

TEST(TokenFile, ABadOneChangesNothing) {
  const TemporaryFolder folder;
  const auto path = folder / "tokens.json";
  EXPECT_THROW(TokenFile{path}, FileError);
  replace_file(path, json({issue().token}), kPrivate);
  TokenFile file(path);
  EXPECT_EQ(file.refresh(), std::nullopt);
  replace_file(path, "{\n\"tokens\": 5}", kPrivate);
  const auto wrong = file.refresh();
  ASSERT_TRUE(wrong.has_value());
  EXPECT_THAT(*wrong, AllOf(HasSubstr("tokens.json:2"), HasSubstr("tokens")));
  EXPECT_EQ(file.refresh(), std::nullopt);  // The error must be reported once.
  EXPECT_EQ(file.tokens().size(), 1u);
  std::filesystem::remove(path);
  EXPECT_TRUE(file.refresh().has_value());
  EXPECT_EQ(file.tokens().size(), 1u);
  replace_file(path, json({}), kPrivate);
  EXPECT_EQ(file.refresh(), std::nullopt);
  EXPECT_TRUE(file.tokens().empty());
  // A change that throws must write nothing.
  EXPECT_THROW(change_tokens(path, [](Tokens&) { throw std::invalid_argument("no"); }),
               std::invalid_argument);
  EXPECT_EQ(text_of(path), json({}));
}

/// The file of a fleet's tokens: it comes later, and a fault of it leaves the others alone.
TEST(TokenFile, TokensOfAnotherFileCountToo) {
  const TemporaryFolder folder;
  const auto path = folder / "tokens.json", more = folder / "more.json";
  const Token own = issue().token, other = issue().token;
  replace_file(path, json({own}), kPrivate);
  TokenFile file(path, more);
  EXPECT_EQ(file.refresh(), std::nullopt);
  EXPECT_EQ(file.tokens().size(), 1u);
  Token same = other;
  same.id = own.id;
  replace_file(more, json({other, same}), kPrivate);
  EXPECT_EQ(file.refresh(), std::nullopt);
  ASSERT_EQ(file.tokens().size(), 2u);
  EXPECT_EQ(find_token(file.tokens(), own.id)->hash, own.hash);
  EXPECT_EQ(TokenFile(path, more).tokens().size(), 2u);
  replace_file(path, json({}), kPrivate);
  replace_file(more, "broken", kPrivate);
  const auto wrong = file.refresh();
  ASSERT_TRUE(wrong.has_value());
  EXPECT_THAT(*wrong, HasSubstr("more.json"));
  EXPECT_NE(find_token(file.tokens(), other.id), nullptr);
  std::filesystem::remove(more);
  EXPECT_TRUE(file.refresh().has_value());
  EXPECT_NE(find_token(file.tokens(), other.id), nullptr);
}

/// A token is revoked while no descriptor is free. It must become invalid when a descriptor is
/// free.
TEST(TokenFile, IsReadAgainWhenItCouldNotBeReadOnce) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "the sanitizer itself needs descriptors to look at an object's type";
#endif
  const TemporaryFolder folder;
  const auto path = folder / "tokens.json";
  replace_file(path, json({issue().token}), kPrivate);
  TokenFile file(path);
  replace_file(path, json({}), kPrivate);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto first = file.refresh(), second = file.refresh();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_TRUE(first.has_value());
  EXPECT_THAT(*first, HasSubstr("Too many open files"));
  EXPECT_EQ(second, std::nullopt);  // The error must be reported once.
  EXPECT_EQ(file.tokens().size(), 1u);
  EXPECT_EQ(file.refresh(), std::nullopt);
  EXPECT_TRUE(file.tokens().empty());
}

TEST(State, IsMadeOnceAndForItsOwnerAlone) {
  const TemporaryFolder folder;
  ServerConfig config;
  config.state = folder / "deep/state";
  const Security made = open_security(config);
  const Security again = open_security(config);
  EXPECT_EQ(made.identity.certificate, again.identity.certificate);
  EXPECT_EQ(text_of(config.state / "fingerprint"), to_string(fingerprint(made.identity)) + "\n");
  const Token* local =
      authenticate(again.tokens.tokens(), text_of(config.state / "local.token"), kNow);
  ASSERT_NE(local, nullptr);
  EXPECT_EQ(local->role, Role::operator_);
  struct stat status {};
  for (const char* name : {"key.pem", "tokens.json", "local.token"}) {
    ASSERT_EQ(::stat((config.state / name).c_str(), &status), 0) << name;
    EXPECT_EQ(status.st_mode & 0777u, kPrivate) << name;
  }
  ASSERT_EQ(::stat(config.state.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0700u);
}

TEST(State, IsCheckedAtARenewalAsAtTheStart) {
  const TemporaryFolder folder;
  ServerConfig config;
  config.state = folder / "state";
  config.client_ca = folder / "ca.pem";
  replace_file(config.client_ca, make_identity({"one"}).certificate, kPublic);
  const Security first = open_security(config);
  EXPECT_EQ(read_security_again(config).client_authorities, first.client_authorities);
  const std::string others = make_identity({"two"}).certificate;
  replace_file(config.client_ca, others, kPublic);
  EXPECT_EQ(read_security_again(config).client_authorities, others);
  EXPECT_EQ(read_security_again(config).identity.certificate, first.identity.certificate);

  const auto expect_refused = [&](const std::string& reason) {
    const std::string again = error_of<FileError>([&] { read_security_again(config); });
    EXPECT_THAT(again, HasSubstr(reason));
    EXPECT_EQ(again, error_of<FileError>([&] { open_security(config); })) << "as at the start";
  };
  for (const char* const text : {"nonsense", "\n", ""}) {
    replace_file(config.client_ca, text, kPublic);
    expect_refused("holds no authority's certificate");
  }
  replace_file(config.client_ca, others, kPublic);
  std::filesystem::permissions(config.state, std::filesystem::perms::all);
  expect_refused("state");
  std::filesystem::permissions(config.state, std::filesystem::perms::owner_all);
  std::filesystem::remove(config.state / "certificate.pem");
  expect_refused("certificate.pem");
  EXPECT_FALSE(std::filesystem::exists(config.state / "certificate.pem"));
}

TEST(State, IsNotNeededWhereAllIsNamed) {
  const TemporaryFolder folder, elsewhere;
  const Identity identity = make_identity({"localhost"});
  ServerConfig config;
  config.certificate = folder / "c.pem";
  config.key = folder / "k.pem";
  config.tokens = folder / "t.json";
  replace_file(config.certificate, identity.certificate, kPublic);
  replace_file(config.key, identity.key.text(), kPrivate);
  // The server must never create a token file that the user named.
  EXPECT_THROW(open_security(config), FileError);
  replace_file(config.tokens, json({}), kPrivate);
  const Security security = open_security(config);
  EXPECT_EQ(fingerprint(security.identity), fingerprint(identity));
  EXPECT_EQ(folder.entries(), 3u);

  // A chain whose second certificate is half written.
  replace_file(config.certificate, identity.certificate + "-----BEGIN CERTIFICATE-----\nAAAA\n",
               kPublic);
  EXPECT_THAT(error_of<FileError>([&] { open_security(config); }),
              HasSubstr(config.certificate.string() + ": TLS refuses it"));
  EXPECT_THROW(read_security_again(config), FileError);
  replace_file(config.certificate, identity.certificate, kPublic);

  replace_file(config.key, identity.key.text(), kPublic);
  EXPECT_THAT(
      error_of<FileError>([&] { open_security(config); }),
      ::testing::AllOf(HasSubstr("(mode 0644)"), HasSubstr("chmod 600 " + config.key.string())));
  replace_file(config.key, make_identity({"localhost"}).key.text(), kPrivate);
  EXPECT_THAT(error_of<FileError>([&] { open_security(config); }),
              HasSubstr("is not the key of the certificate"));
  replace_file(config.key, "nonsense", kPrivate);
  EXPECT_THAT(error_of<FileError>([&] { open_security(config); }), HasSubstr("no private key"));
  replace_file(config.certificate, "nonsense", kPublic);
  EXPECT_THAT(error_of<FileError>([&] { open_security(config); }), HasSubstr("no certificate"));
}

TEST(Fingerprints, AreReadAsTheyAreWritten) {
  const Fingerprint print = fingerprint(make_identity({"localhost"}));
  const std::string text = to_string(print);
  EXPECT_EQ(text.size(), 64u);
  EXPECT_EQ(parse_fingerprint(text), print);
  std::string colons;
  for (std::size_t i = 0; i < text.size(); i += 2) colons += (i > 0 ? ":" : "") + text.substr(i, 2);
  for (char& c : colons) c = static_cast<char>(std::toupper(c));
  EXPECT_EQ(parse_fingerprint(colons), print);
  for (const std::string& wrong :
       {std::string(), text.substr(1), text + "00", text.substr(2) + "gg"})
    EXPECT_THROW(parse_fingerprint(wrong), std::invalid_argument) << wrong;
}

}  // namespace
}  // namespace feltwire::tokens_test
