#include "core/base/json_document.hpp"

#include <flatbuffers/idl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/json_member.hpp"

namespace feltwire::json_document_test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kSchema = R"(
  enum Level: ubyte { quiet, loud }
  struct Place { x: double; y: double; tag: ubyte; }
  table Part { port: ushort; offset: int; ratio: float; level: Level; on: bool; names: [string];
               place: Place; }
  table Whole { title: string (required); part: Part; parts: [Part]; large: ulong;
                places: [Place]; flags: [bool]; levels: [Level]; }
  root_type Whole;)";

std::string document_error(const std::string& json) {
  try {
    const JsonDocument document(json, "c.json", kSchema);
  } catch (const FileError& error) {
    return error.what();
  }
  return "no error";
}

TEST(JsonDocument, ChecksScalarsAgainstTheirTypes) {
  const auto part = [](const std::string& inner) {
    return document_error("{\"title\": \"t\",\n\"part\": {" + inner + "}}");
  };
  EXPECT_EQ(part(R"("port": 65535, "offset": -2147483648, "ratio": 0.5, "level": "loud", "on": true,
                     "names": ["a", "b"])"),
            "no error");
  EXPECT_THAT(part(R"("port": 65536)"), StartsWith("c.json:2: part.port: does not fit, is '65536'; "
                                                   "choose a number from 0 to 65535"));
  EXPECT_THAT(part(R"("port": -1)"), StartsWith("c.json:2: part.port: does not fit"));
  EXPECT_THAT(part(R"("port": 1.0)"), StartsWith("c.json:2: part.port: must be a whole number"));
  EXPECT_THAT(part(R"("offset": 2147483648)"), StartsWith("c.json:2: part.offset: does not fit"));
  EXPECT_THAT(part(R"("ratio": 1e39)"), StartsWith("c.json:2: part.ratio: is too large"));
  EXPECT_THAT(part(R"("on": 1)"), StartsWith("c.json:2: part.on: must be true or false"));
  EXPECT_THAT(part(R"("level": "silent")"),
              StartsWith("c.json:2: part.level: must be one of: quiet, "
                         "loud; is the text"));
  EXPECT_THAT(part(R"("names": ["a", 1])"), StartsWith("c.json:2: part.names[1]: must be a text"));
  EXPECT_THAT(part(R"("names": "a")"), StartsWith("c.json:2: part.names: must be a list"));
  EXPECT_EQ(document_error(R"({"title": "t", "large": 18446744073709551615})"), "no error");
  EXPECT_THAT(document_error(R"({"title": "t", "large": 18446744073709551616})"),
              HasSubstr("large: does not fit"));
}

TEST(JsonDocument, AWrongKindOfValueIsToldTheFields) {
  const auto error = [](const std::string& inner) {
    return document_error("{\"title\": \"t\",\n" + inner + "}");
  };
  EXPECT_THAT(error(R"("part": "a.xml")"),
              AllOf(StartsWith("c.json:2: part: must be an object, is the text 'a.xml'; write { "),
                    HasSubstr("its fields are: port, offset, ratio, level, on, names, place")));
  EXPECT_THAT(error(R"("part": {"place": 0.1})"),
              StartsWith("c.json:2: part.place: must be a list of 3 numbers, is '0.1'; write "
                         "[x, y, tag]"));
  EXPECT_THAT(error(R"("parts": {"port": 1})"),
              AllOf(StartsWith("c.json:2: parts: must be a list, is an object"),
                    HasSubstr("its fields are: port, ")));
  EXPECT_THAT(error(R"("places": 3)"), HasSubstr("each as [x, y, tag]"));
  EXPECT_THAT(document_error("[]"),
              HasSubstr("write { \"title\": ... }; its fields are: title, part"));
}

TEST(JsonDocument, OtherNotationsAreNamed) {
  const auto expect_told = [](const std::string& text, const char* what) {
    EXPECT_THAT(document_error(text), AllOf(StartsWith("c.json:"), HasSubstr(what))) << text;
  };
  for (const char* yaml : {"title: t\n", "---\ntitle: t\n", "# a comment\n\ntitle: t\n",
                           "- title: t\n", "%YAML 1.2\n---\n", "\"title\": t\n", "my-title : t\n",
                           "# a\n# b\n---\n", "\xEF\xBB\xBFtitle:\n  part: 1\n"})
    expect_told(yaml, "is YAML, not JSON");
  expect_told("title = \"t\"\n", "is TOML or an INI file");
  expect_told("# c\n[part]\nport = 1\n", "is TOML or an INI file");
  expect_told("<mujoco model=\"a\"/>", "is XML, not JSON; a scene names an MJCF");
  expect_told("# only a comment\n", "a comment in JSON begins with //");
  expect_told("version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 2\n", "git lfs pull");
  expect_told("<!doctype html><html>", "is a web page");
  expect_told("\x1F\x8B\x08", "gunzip");
  EXPECT_EQ(document_error("\xEF\xBB\xBF// c\n{\"title\": \"t\"}"), "no error");
  EXPECT_EQ(document_error("{title: \"t\"}"), "no error");
}

TEST(JsonDocument, AMemberIsReadWithoutASchema) {
  EXPECT_EQ(json_text_member(R"({"a": 1, "name": "r\u006fom"})", "name"), "room");
  EXPECT_EQ(json_text_member(R"({"a": {"name": "x"}})", "name"), std::nullopt);
  EXPECT_EQ(json_text_member(R"({"name": 1})", "name"), std::nullopt);
  EXPECT_EQ(json_text_member("name: room", "name"), std::nullopt);
}

TEST(JsonDocument, WritesWhatTheTextSays) {
  flatbuffers::Parser parser;
  ASSERT_TRUE(parser.Parse(kSchema));
  parser.opts.strict_json = true;
  parser.opts.indent_step = -1;
  const auto written = [&](const std::string& json) {
    const JsonDocument document(json, "c.json", kSchema);
    std::string text;
    EXPECT_TRUE(flatbuffers::GenerateText(parser, document.buffer(), &text));
    return text;
  };
  // The document must read and write these texts in the same way as FlatBuffers.
  for (const char* same : {
           R"({"title": "", "parts": [], "large": 18446744073709551615,
               "part": {"port": 65535, "offset": -2147483648, "ratio": 0.1, "level": "loud",
                        "on": true, "names": ["a", "", "bc"]}})",
           R"({"title": "t", "flags": [true, false, true], "levels": ["loud", "quiet"],
               "parts": [{}, {"offset": -1, "names": []},
                         {"place": {"x": 1.5, "y": -2.5, "tag": 7}}],
               "places": [{"x": 0.1, "y": 1e-300, "tag": 1}, {"x": 3.0, "y": 4.0, "tag": 2}]})"}) {
    ASSERT_TRUE(parser.Parse(same)) << parser.error_;
    std::string theirs;
    ASSERT_TRUE(flatbuffers::GenerateText(parser, parser.builder_.GetBufferPointer(), &theirs));
    EXPECT_EQ(written(same), theirs);
  }
}

TEST(JsonDocument, ReadsEscapes) {
  const auto title = [](const std::string& written) {
    const JsonDocument document("{\"title\": \"" + written + "\"}", "c.json", kSchema);
    const auto* whole = flatbuffers::GetRoot<flatbuffers::Table>(document.buffer());
    return whole->GetPointer<const flatbuffers::String*>(flatbuffers::FieldIndexToOffset(0))->str();
  };
  EXPECT_EQ(title(R"(\"\\\/\b\f\n\r\t\u0041bf)"), "\"\\/\b\f\n\r\tAbf");
  EXPECT_EQ(title(R"(\u00e9\u20AC\uD83D\ude00\uFFFF)"),
            "\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80\xEF\xBF\xBF");
  EXPECT_EQ(title("\xF0\x9F\x98\x80"), "\xF0\x9F\x98\x80");
  EXPECT_EQ(title(R"(a\u0000b)"), std::string("a\0b", 3));
}

TEST(JsonDocument, KnowsTheLineOfEveryValue) {
  const JsonDocument document(
      "{\n\"title\":\n\"t\", /* two\n lines */ \"parts\": [\n{},\n{ \"port\": 1,\n\"offset\": 2 "
      "}]}",
      "c.json", kSchema);
  EXPECT_EQ(document.line_of(""), 1);
  EXPECT_EQ(document.line_of("title"), 3);
  EXPECT_EQ(document.line_of("parts"), 4);
  EXPECT_EQ(document.line_of("parts[0]"), 5);
  EXPECT_EQ(document.line_of("parts[1].offset"), 7);
  // The text lacks this value, so the document must report the line of the parent.
  EXPECT_EQ(document.line_of("parts[1].ratio"), 6);
  EXPECT_EQ(document.line_of("parts[7].ratio"), 4);
  EXPECT_EQ(document.line_of("nothing.at.all"), 1);
  EXPECT_EQ(document.line_of("parts[].[..]"), 5);  // an invalid path
  try {
    document.fail("parts[1].offset", "is odd; make it even");
    FAIL() << "fail() must throw";
  } catch (const FileError& error) {
    EXPECT_STREQ(error.what(), "c.json:7: parts[1].offset: is odd; make it even");
  }
}

}  // namespace
}  // namespace feltwire::json_document_test
