// Tests answers to requests: the page's files, the right to view, and the policy of every answer.

#include "server/web/http_responses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace feltwire::web::http_responses_test {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr std::array<unsigned char, 3> kFile = {'a', 'b', 'c'};
const std::array<PageAsset, 1> kPage = {{{"/", "text/html", "1234", kFile}}};

std::string text(const HttpResponse& answer) {
  return std::string(answer.bytes.begin(), answer.bytes.end()) + std::string(answer.body.text());
}

std::string asked(const std::string& head, bool secure = false,
                  std::vector<std::string> names = {}) {
  const auto request = parse_http_head(head + "\r\n");
  Site site{kPage, names, secure};
  site.metrics = [] { return std::string("feltwire_sessions 1\n"); };
  site.opens = [](std::string_view token) { return token == "fw_good"; };
  site.mint = [](std::string_view, std::string_view scene) {
    return scene == "a room" ? std::optional(Secret("fw_ticket")) : std::nullopt;
  };
  site.redeem = [](std::string_view ticket) {
    return ticket == "fw_ticket" ? std::optional(ViewTicket{"id", "a room"}) : std::nullopt;
  };
  return text(http_response(request ? &*request : nullptr, site));
}
std::string get(const std::string& path, const std::string& headers,
                const std::string& host = "127.0.0.1:7480") {
  return "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\n" + headers;
}

const std::string kUpgrade =
    "Connection: keep-alive, Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    "Sec-WebSocket-Protocol: feltwire.live.v1\r\n";
const std::string kOrigin = "Origin: http://127.0.0.1:7480\r\n";

TEST(Answers, TheFileAsItWasCompressed) {
  const std::string whole = asked(get("/", ""));
  EXPECT_THAT(whole, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(whole, HasSubstr("Content-Type: text/html\r\n"));
  EXPECT_THAT(whole, HasSubstr("Content-Encoding: gzip\r\n"));
  EXPECT_THAT(whole, HasSubstr("Content-Length: 3\r\n"));
  EXPECT_THAT(whole, EndsWith("\r\n\r\nabc"));
  EXPECT_THAT(asked("HEAD / HTTP/1.1\r\nHost: 127.0.0.1\r\n"), EndsWith("\r\n\r\n"));
  // The answer must use the stored bytes, so many slow readers need no copies.
  const auto request = parse_http_head(get("/", "") + "\r\n");
  EXPECT_EQ(http_response(&*request, {kPage, {}, false}).body.bytes().data(), kFile.data());
  EXPECT_THAT(asked(get("/", "If-None-Match: \"1234\"\r\n")), StartsWith("HTTP/1.1 304 "));
  EXPECT_THAT(asked(get("/", "If-None-Match: \"123\"\r\n")), StartsWith("HTTP/1.1 200 "));
}

TEST(Answers, NotReadyWhileASceneIsNotSeen) {
  Site site{kPage, {}, false};
  const auto ready = [&](const std::string& path, const std::string& headers = "") {
    const auto request = parse_http_head(get(path, headers) + "\r\n");
    return text(http_response(&*request, site));
  };
  EXPECT_THAT(ready("/ready"), StartsWith("HTTP/1.1 200 "));
  site.hidden_scene = [](std::string_view token) {
    return std::optional<std::string>(token == "fw_good" ? "room" : "");
  };
  EXPECT_THAT(ready("/ready"), StartsWith("HTTP/1.1 503 "));
  EXPECT_THAT(ready("/ready"), HasSubstr("a scene is not seen"));
  const std::string good = ready("/ready", "Authorization: Bearer fw_good\r\n");
  EXPECT_THAT(good, StartsWith("HTTP/1.1 503 "));
  EXPECT_THAT(good, HasSubstr("scene room is not seen"));
  EXPECT_THAT(ready("/health"), StartsWith("HTTP/1.1 200 "));
}

TEST(Answers, EveryAnswerHasThePolicy) {
  for (const std::string& answer :
       {asked(get("/", "")), asked(get("/none", "")), asked("nonsense"), asked(get("/live", "")),
        asked(get("/", "", "evil.example")), asked(get("/health", ""))}) {
    EXPECT_THAT(answer, HasSubstr("Content-Security-Policy: default-src 'none'; "
                                  "script-src 'self'; style-src 'self';"));
    EXPECT_THAT(answer, Not(HasSubstr("unsafe")));
    EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff\r\n"));
    EXPECT_THAT(answer, HasSubstr("Connection: close\r\n"));
  }
}

TEST(Answers, WhatIsNotThere) {
  EXPECT_THAT(asked(get("/none", "")), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(asked("POST / HTTP/1.1\r\nHost: 127.0.0.1\r\n"), StartsWith("HTTP/1.1 405 "));
  EXPECT_THAT(asked("nonsense"), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(asked(get("/health", "")), EndsWith("ok\n"));
  const auto request = parse_http_head(get("/", "") + "\r\n");
  EXPECT_THAT(text(http_response(&*request, {})), HasSubstr("nodejs and npm"));
}

/// On this machine every client may request the metrics. Over a network a token is necessary.
TEST(Answers, Metrics) {
  EXPECT_THAT(asked(get("/metrics", "")), EndsWith("\r\n\r\nfeltwire_sessions 1\n"));
  EXPECT_THAT(asked(get("/metrics", ""), true), StartsWith("HTTP/1.1 401 "));
  EXPECT_THAT(asked(get("/metrics", "Authorization: Bearer fw_bad\r\n"), true),
              StartsWith("HTTP/1.1 401 "));
  EXPECT_THAT(asked(get("/metrics", "Authorization: fw_good\r\n"), true),
              StartsWith("HTTP/1.1 401 "));
  EXPECT_THAT(asked(get("/metrics", "Authorization: Bearer fw_good\r\n"), true),
              EndsWith("feltwire_sessions 1\n"));
  const auto request = parse_http_head(get("/metrics", "") + "\r\n");
  EXPECT_THAT(text(http_response(&*request, {kPage, {}, false})), StartsWith("HTTP/1.1 404 "));
}

/// The server must not answer to a foreign name that leads to this machine (DNS rebinding).
TEST(Answers, OnlyByItsOwnNames) {
  for (const std::string ours : {"127.0.0.1", "127.0.0.1:7480", "localhost:1", "[::1]:7480",
                                 "192.168.1.5", "[::1]", "LocalHost", "localhost.", "localhost.:80",
                                 "[2001:DB8::1]:65535", "[::ffff:127.0.0.1]", "127.0.0.1."})
    EXPECT_THAT(asked(get("/", "", ours)), StartsWith("HTTP/1.1 200 ")) << ours;
  for (const std::string other : {"evil.example",
                                  "evil.example:7480",
                                  "127.0.0.1.evil.example",
                                  "localhost.evil.example",
                                  "",
                                  "[",
                                  "[::1",
                                  "[::1]evil",
                                  "[::1]evil:80",
                                  "[::1].evil.example",
                                  "[::1]:",
                                  "[::1]:80x",
                                  "[::1]:0",
                                  "[::1]:65536",
                                  "[::1]:80:80",
                                  "[::1%evil]",
                                  "[::1%25lo]",
                                  "[127.0.0.1]",
                                  "[localhost]",
                                  "[]",
                                  "::1",
                                  "127.0.0.1:",
                                  "127.0.0.1:+80",
                                  "127.0.0.1:99999999999",
                                  "localhost:80@evil.example",
                                  "localhost@evil.example",
                                  "evil.example@localhost",
                                  "127.0.0.1/",
                                  "127.0.0.1 evil.example",
                                  "127.0.0.1,evil.example",
                                  "localhost..",
                                  ".localhost",
                                  "local..host",
                                  "127.1",
                                  "0x7f000001",
                                  "2130706433"})
    EXPECT_THAT(asked(get("/", "", other)), StartsWith("HTTP/1.1 403 ")) << other;
  EXPECT_THAT(asked("GET / HTTP/1.1\r\n"), StartsWith("HTTP/1.1 403 "));
  for (const std::string lab : {"lab.example:1", "LAB.Example", "lab.example."})
    EXPECT_THAT(asked(get("/", "", lab), false, {"Lab.example"}), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(asked(get("/", "", "xlab.example"), false, {"lab.example"}),
              StartsWith("HTTP/1.1 403 "));
}

TEST(Answers, AWebSocketOfItsOwnPage) {
  const std::string accepted = asked(get("/live", kUpgrade + kOrigin));
  EXPECT_THAT(accepted, StartsWith("HTTP/1.1 101 "));
  EXPECT_THAT(accepted, HasSubstr("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"));
  EXPECT_THAT(accepted, HasSubstr("Sec-WebSocket-Protocol: feltwire.live.v1\r\n\r\n"));
  const auto request = parse_http_head(get("/live", kUpgrade + kOrigin) + "\r\n");
  EXPECT_TRUE(http_response(&*request, {kPage, {}, false}).upgraded);
  EXPECT_FALSE(http_response(&*request, {kPage, {}, true}).upgraded);  // http and https differ.
}

TEST(Answers, NoWebSocketOfAnotherPage) {
  for (const std::string origin :
       {"", "Origin: null\r\n", "Origin: http://evil.example\r\n", "Origin: http://127.0.0.1\r\n",
        "Origin: https://127.0.0.1:7480\r\n", "Origin: http://127.0.0.1:7481\r\n",
        "Origin: http://127.0.0.1:7480.evil.example\r\n"})
    EXPECT_THAT(asked(get("/live", kUpgrade + origin)), StartsWith("HTTP/1.1 403 ")) << origin;
}

/// A proxy on this machine uses TLS to browsers and HTTP to this server.
TEST(Answers, AWebSocketThroughAProxyThatSpeaksTls) {
  const auto status = [](const std::string& host, const std::string& origin, bool secure = false) {
    const std::string answer =
        asked(get("/live", kUpgrade + "Origin: " + origin + "\r\n", host), secure, {"lab.example"});
    return answer.substr(answer.find(' ') + 1, 3);
  };
  EXPECT_EQ(status("lab.example", "https://lab.example"), "101");
  EXPECT_EQ(status("lab.example:8443", "https://lab.example:8443"), "101");
  // Proxies may write the default port, but browsers omit it.
  EXPECT_EQ(status("lab.example:443", "https://lab.example"), "101");
  EXPECT_EQ(status("lab.example:80", "http://lab.example"), "101");
  EXPECT_EQ(status("lab.example", "http://lab.example"), "101");
  EXPECT_EQ(status("lab.example", "https://lab.example", true), "101");
  // The server must refuse another site, or a proxy that was not named.
  EXPECT_EQ(status("lab.example", "https://evil.example"), "403");
  EXPECT_EQ(status("lab.example", "https://lab.example.evil.example"), "403");
  EXPECT_EQ(status("lab.example", "https://evil.lab.example"), "403");
  EXPECT_EQ(status("lab.example", "https://lab.example:8443"), "403");
  EXPECT_EQ(status("lab.example:443", "http://lab.example"), "403");
  EXPECT_EQ(status("lab.example", "http://lab.example", true), "403");
  EXPECT_EQ(status("localhost:7480", "https://localhost:7480"), "403");
  EXPECT_EQ(status("127.0.0.1", "https://lab.example"), "403");
}

std::string foxglove(std::string_view protocols) {
  std::string headers = kUpgrade;
  const std::string ours = "feltwire.live.v1";
  return headers.replace(headers.find(ours), ours.size(), protocols);
}

/// A ticket is sufficient proof. Any page or program may use it.
TEST(Answers, AWebSocketForATicket) {
  for (const std::string origin :
       {"", "Origin: https://app.foxglove.dev\r\n", "Origin: file://\r\n"})
    EXPECT_THAT(asked(get("/foxglove?ticket=fw_ticket", foxglove("foxglove.sdk.v1") + origin)),
                HasSubstr("\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"))
        << origin;
  EXPECT_THAT(asked(get("/foxglove?a=1&ticket=fw_ticket", foxglove("foxglove.websocket.v1"))),
              EndsWith("\r\nSec-WebSocket-Protocol: foxglove.websocket.v1\r\n\r\n"));
  for (const std::string query : {"", "?ticket=", "?ticket=fw_other", "?tickets=fw_ticket"})
    EXPECT_THAT(asked(get("/foxglove" + query, foxglove("foxglove.sdk.v1"))),
                StartsWith("HTTP/1.1 403 "))
        << query;
  EXPECT_THAT(asked(get("/foxglove?ticket=fw_ticket", kUpgrade)), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(asked(get("/foxglove?ticket=fw_ticket", "")), StartsWith("HTTP/1.1 426 "));
  EXPECT_THAT(asked(get("/foxglove?ticket=fw_ticket", foxglove("foxglove.sdk.v1"), "evil.example")),
              StartsWith("HTTP/1.1 403 "));
}

TEST(Answers, ATicketForAToken) {
  const std::string shown = "Authorization: Bearer fw_good\r\n";
  EXPECT_THAT(asked(get("/ticket?scene=a%20room", shown)),
              EndsWith("\r\n\r\nws://127.0.0.1:7480/foxglove?ticket=fw_ticket\n"));
  EXPECT_THAT(asked(get("/ticket?scene=a%20room", shown), true), HasSubstr("\nwss://"));
  // A proxy reports the scheme that its client used.
  EXPECT_THAT(asked(get("/ticket?scene=a%20room", shown + "X-Forwarded-Proto: https\r\n")),
              HasSubstr("\nwss://127.0.0.1:7480/"));
  EXPECT_THAT(asked(get("/ticket?scene=a%20room", shown + "X-Forwarded-Proto: http\r\n")),
              HasSubstr("\nws://127.0.0.1:7480/"));
  // A proxy reports the folder of its host in which it serves the page.
  for (const std::string folder : {"/feltwire", "/feltwire/"})
    EXPECT_THAT(
        asked(get("/ticket?scene=a%20room", shown + "X-Forwarded-Prefix: " + folder + "\r\n")),
        EndsWith("\nws://127.0.0.1:7480/feltwire/foxglove?ticket=fw_ticket\n"));
  for (const std::string folder : {"", "/", "//evil.example", ".evil.example", "/a b", "/a?b"})
    EXPECT_THAT(
        asked(get("/ticket?scene=a%20room", shown + "X-Forwarded-Prefix: " + folder + "\r\n")),
        EndsWith("\nws://127.0.0.1:7480/foxglove?ticket=fw_ticket\n"))
        << folder;
  EXPECT_THAT(asked(get("/ticket?scene=a%20room", shown)), HasSubstr("Cache-Control: no-store"));
  EXPECT_THAT(asked(get("/ticket?scene=cellar", shown)), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(asked(get("/ticket?scene=a%20room", "")), StartsWith("HTTP/1.1 401 "));
  EXPECT_THAT(asked(get("/ticket?scene=a%20room", "Authorization: Bearer fw_bad\r\n")),
              StartsWith("HTTP/1.1 401 "));
}

TEST(Answers, NoHalfAWebSocket) {
  const auto without = [](const std::string& line) {
    std::string headers = kUpgrade + kOrigin;
    const auto at = headers.find(line);
    return asked(get("/live", headers.erase(at, headers.find("\r\n", at) + 2 - at)));
  };
  EXPECT_THAT(without("Connection"), StartsWith("HTTP/1.1 426 "));
  EXPECT_THAT(without("Upgrade:"), StartsWith("HTTP/1.1 426 "));
  EXPECT_THAT(without("Sec-WebSocket-Version"), StartsWith("HTTP/1.1 426 "));
  EXPECT_THAT(without("Sec-WebSocket-Key"), StartsWith("HTTP/1.1 400 "));
  EXPECT_THAT(without("Sec-WebSocket-Protocol"), StartsWith("HTTP/1.1 400 "));
}

TEST(Answers, APortForCountersHasNothingElse) {
  Site site{kPage, {}, false};
  site.counters_only = true;
  site.metrics = [] { return std::string("feltwire_sessions 1\n"); };
  const auto ask = [&](const std::string& path, const std::string& headers) {
    const auto request = parse_http_head(get(path, headers) + "\r\n");
    return text(http_response(&*request, site));
  };
  EXPECT_THAT(ask("/metrics", ""), EndsWith("feltwire_sessions 1\n"));
  EXPECT_THAT(ask("/health", ""), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(ask("/ready", ""), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(ask("/", ""), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(ask("/ticket", ""), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(ask("/live", kUpgrade), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(ask("/foxglove", kUpgrade), StartsWith("HTTP/1.1 404 "));
}

/// A valid token or ticket must get an answer after any number of wrong tokens.
TEST(Answers, WrongTokensAndTicketsAreLimited) {
  Site site{kPage, {}, true};
  int left = 3;
  site.may_try_again = [&] { return left-- > 0; };
  site.metrics = [] { return std::string("feltwire_sessions 1\n"); };
  site.opens = [](std::string_view token) { return token == "fw_good"; };
  site.mint = [](std::string_view, std::string_view) { return std::optional(Secret("fw_ticket")); };
  site.redeem = [](std::string_view ticket) {
    return ticket == "fw_ticket" ? std::optional(ViewTicket{"id", "a room"}) : std::nullopt;
  };
  const auto ask = [&](const std::string& path, const std::string& headers) {
    const auto request = parse_http_head(get(path, headers) + "\r\n");
    return text(http_response(&*request, site));
  };
  const std::string wrong = "Authorization: Bearer fw_wrong\r\n";
  // A missing token must not count as a wrong token.
  EXPECT_THAT(ask("/ticket", ""), StartsWith("HTTP/1.1 401 "));
  EXPECT_EQ(left, 3);
  EXPECT_THAT(ask("/ticket", wrong), StartsWith("HTTP/1.1 401 "));
  EXPECT_THAT(ask("/metrics", wrong), StartsWith("HTTP/1.1 401 "));
  std::string upgrade = kUpgrade;
  upgrade.replace(upgrade.find("feltwire.live.v1"), 16, "foxglove.sdk.v1");
  EXPECT_THAT(ask("/foxglove?ticket=fw_wrong", upgrade), StartsWith("HTTP/1.1 403 "));
  for (int n = 0; n < 3; ++n) {
    const std::string refused = ask("/ticket", wrong);
    EXPECT_THAT(refused, StartsWith("HTTP/1.1 429 "));
    EXPECT_THAT(refused, HasSubstr("Retry-After: 60\r\n"));
    EXPECT_THAT(ask("/metrics", wrong), StartsWith("HTTP/1.1 429 "));
    EXPECT_THAT(ask("/foxglove?ticket=fw_wrong", upgrade), StartsWith("HTTP/1.1 429 "));
  }
  EXPECT_THAT(ask("/ticket", "Authorization: Bearer fw_good\r\n"), StartsWith("HTTP/1.1 200 "));
  EXPECT_THAT(ask("/foxglove?ticket=fw_ticket", upgrade), StartsWith("HTTP/1.1 101 "));
}

}  // namespace
}  // namespace feltwire::web::http_responses_test
