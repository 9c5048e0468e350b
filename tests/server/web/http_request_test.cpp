// Tests heads of requests, valid and refused.

#include "server/web/http_request.hpp"

#include <gtest/gtest.h>

namespace feltwire::http_request_test {
namespace {

std::string get(const std::string& target, const std::string& headers = "") {
  return "GET " + target + " HTTP/1.1\r\nHost: here\r\n" + headers + "\r\n";
}

TEST(HttpRequest, ReadsWhatABrowserSends) {
  const auto request =
      parse_http_head(get("/app.js?v=2", "Accept:  text/html , */* \r\nX-EMPTY:\r\n"));
  ASSERT_TRUE(request);
  EXPECT_EQ(request->method, "GET");
  EXPECT_EQ(request->path, "/app.js");
  EXPECT_EQ(request->query, "v=2");
  ASSERT_NE(request->header("accept"), nullptr);
  EXPECT_EQ(*request->header("accept"), "text/html , */*");
  ASSERT_NE(request->header("x-empty"), nullptr);
  EXPECT_EQ(*request->header("x-empty"), "");
  EXPECT_EQ(request->header("origin"), nullptr);
}

TEST(HttpRequest, AHeaderThatComesTwiceIsNone) {
  const auto request = parse_http_head(get("/", "Host: there\r\n"));
  ASSERT_TRUE(request);
  EXPECT_EQ(request->header("host"), nullptr);
}

TEST(HttpRequest, TheHeadEndsAtItsEmptyLine) {
  EXPECT_FALSE(http_head_length(""));
  EXPECT_FALSE(http_head_length("GET / HTTP/1.1\r\nHost: here\r\n"));
  const std::string head = get("/");
  EXPECT_EQ(http_head_length(head + "more"), head.size());
}

TEST(HttpRequest, RefusesWhatNoBrowserSends) {
  for (const std::string& wrong : {
           std::string("\r\n"),
           std::string("GET /\r\n\r\n"),
           std::string("GET / HTTP/1.0\r\n\r\n"),
           std::string("GET / HTTP/2\r\n\r\n"),
           std::string("GET  / HTTP/1.1\r\n\r\n"),
           std::string("G@T / HTTP/1.1\r\n\r\n"),
           get("app.js"),
           get("/../key"),
           get("/a/..%2f"),
           get("//there/x"),
           get("/%41"),
           get("http://there/"),
           get("/a b"),
           get("/a\tb?\x7f"),
           get("/", "NoColon\r\n"),
           get("/", "Na me: x\r\n"),
           get("/", " folded: x\r\n"),
           get("/", "A: \x01\r\n"),
           get("/", "A: b\nC: d\r\n"),
           get("/", ": x\r\n"),
           get("/", "Content-Length: 5\r\n"),
           get("/", "Transfer-Encoding: chunked\r\n"),
           get("/").substr(0, get("/").size() - 1),
       })
    EXPECT_FALSE(parse_http_head(wrong)) << wrong;
}

TEST(HttpRequest, RefusesTooMuch) {
  EXPECT_TRUE(parse_http_head(get("/", "A: " + std::string(kMaxHttpHead - 60, 'a') + "\r\n")));
  EXPECT_FALSE(parse_http_head(get("/", "A: " + std::string(kMaxHttpHead, 'a') + "\r\n")));
  std::string many;
  for (int i = 0; i < 100; ++i) many += "A: b\r\n";
  EXPECT_FALSE(parse_http_head(get("/", many)));
}

TEST(HttpRequest, FindsAMemberOfAList) {
  EXPECT_TRUE(has_member("keep-alive, Upgrade", "upgrade"));
  EXPECT_TRUE(has_member("UPGRADE", "upgrade"));
  EXPECT_TRUE(has_member(",, upgrade ,", "upgrade"));
  EXPECT_FALSE(has_member("upgrades", "upgrade"));
  EXPECT_FALSE(has_member("", "upgrade"));
}

/// This is the example of RFC 6455, 1.3.
TEST(HttpRequest, AcceptsAWebSocketsKey) {
  EXPECT_EQ(websocket_accept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_FALSE(websocket_accept(""));
  EXPECT_FALSE(websocket_accept("dGhlIHNhbXBsZSBub25jZQ="));
  EXPECT_FALSE(websocket_accept("dGhlIHNhbXBsZSBub25j!Q=="));
}

}  // namespace
}  // namespace feltwire::http_request_test
