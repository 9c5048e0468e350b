#include "core/base/foreign_content.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace feltwire {
namespace {

using namespace std::string_view_literals;

/// Returns true if the text begins with `lower`, in upper or lower case. `lower` must be in lower
/// case.
bool begins_with(std::string_view text, std::string_view lower) {
  return text.size() >= lower.size() &&
         std::equal(lower.begin(), lower.end(), text.begin(), [](char a, char b) {
           return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
         });
}

struct Packed {
  std::string_view begin;
  const char* what;
};
constexpr std::array<Packed, 8> kPacked = {
    {{"\x1F\x8B"sv, "is packed with gzip; unpack it with: gunzip"},
     {"PK\x03\x04"sv, "is a zip archive; unpack it, and name a file of it"},
     {"PK\x05\x06"sv, "is an empty zip archive; copy it anew"},
     {"BZh"sv, "is packed with bzip2; unpack it with: bunzip2"},
     {"\xFD"
      "7zXZ\0"sv,
      "is packed with xz; unpack it with: unxz"},
     {"\x28\xB5\x2F\xFD"sv, "is packed with zstd; unpack it with: unzstd"},
     {"7z\xBC\xAF\x27\x1C"sv, "is a 7z archive; unpack it, and name a file of it"},
     {"Rar!\x1A\x07"sv, "is a rar archive; unpack it, and name a file of it"}}};

/// Returns true if the text is a web page that a server sent instead of the file.
bool is_web_page(std::string_view text) {
  constexpr std::array<std::string_view, 4> kBegins = {"<!doctype html", "<html", "<head", "<body"};
  return std::ranges::any_of(kBegins, [&](std::string_view b) { return begins_with(text, b); });
}

}  // namespace

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

std::optional<std::string> foreign_content(std::string_view bytes) {
  // [bytes] largest size of a pointer file in the specification of Git LFS.
  constexpr std::size_t kLongestPointer = 1024;
  for (const Packed& packed : kPacked)
    if (bytes.starts_with(packed.begin)) return packed.what;
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"))
    return "is text in UTF-16; save it as UTF-8";
  std::string_view text = without_byte_order_mark(bytes);
  const std::size_t first = text.find_first_not_of(" \t\r\n\v\f");
  text.remove_prefix(std::min(first, text.size()));
  if (text.starts_with("version https://git-lfs") ||
      (text.starts_with("version http") && bytes.size() <= kLongestPointer &&
       text.find("\noid sha256:") != std::string_view::npos))
    return "is a pointer of Git LFS, not the file itself; fetch it with: git lfs pull";
  if (bytes.size() <= kLongestPointer && text.find("/annex/objects/") != std::string_view::npos)
    return "is a pointer of git-annex, not the file itself; fetch it with: git annex get";
  if (is_web_page(text))
    return "is a web page, not the file itself; download the file, not the page about it";
  return std::nullopt;
}

}  // namespace feltwire
