#include "core/mesh/mesh_file.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <limits>

#include "core/base/foreign_content.hpp"
#include "core/base/regular_file.hpp"
#include "core/mesh/mesh_text.hpp"

namespace feltwire {
namespace {

using mesh_text::broken_vertex;
using mesh_text::is_word;
using mesh_text::TokenReader;

constexpr std::size_t kMostVertices = std::numeric_limits<std::uint32_t>::max() - 1;

/// Returns true if a line of an OBJ file with this first word describes no surface: appearance,
/// grouping, or free-form curves.
bool is_no_surface(std::string_view word) {
  for (const std::string_view known :
       {"vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p", "mg", "lod", "bevel",
        "c_interp", "d_interp", "shadow_obj", "trace_obj", "maplib", "usemap"})
    if (is_word(word, known)) return true;
  return false;
}

/// The vertex indices in the faces of an OBJ file. A face may come before its vertices.
class ObjIndices {
 public:
  explicit ObjIndices(const TokenReader& words) : words_(words) {}

  /// Reads the vertex index of "7", "7/1", "7//3" or "-1". A positive index counts from 1. A
  /// negative index counts backwards from the last of `vertices` vertices.
  std::uint32_t read(std::string_view word, std::size_t vertices) {
    const long long index = words_.whole(word.substr(0, word.find('/')), "face");
    const auto count = static_cast<long long>(vertices);
    if (index == 0 || index > static_cast<long long>(kMostVertices) || index < -count)
      words_.fail(missing(index, vertices) + " so far; export the surface anew");
    if (index > count && (early_.empty() || index > early_.back().index))
      early_.push_back({index, words_.line()});
    return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
  }

  /// Checks the forward references when the file ends with `vertices` vertices.
  void check(std::size_t vertices) const {
    for (const ForwardReference& early : early_)
      if (early.index > static_cast<long long>(vertices))
        words_.fail_at(early.line, missing(early.index, vertices) + "; export the surface anew");
  }

 private:
  struct ForwardReference {
    long long index;
    int line;
  };

  static std::string missing(long long index, std::size_t vertices) {
    return "face: vertex " + std::to_string(index) + " does not exist, there are " +
           std::to_string(vertices);
  }

  const TokenReader& words_;
  std::vector<ForwardReference> early_;  // forward references, in ascending order
};

constexpr std::size_t kStlHeader = 84, kStlRecord = 50, kStlCountAt = 80;

/// Skips comments and blank lines, because some programs write them before the first word.
std::string_view without_first_lines(std::string_view text) {
  for (text = without_byte_order_mark(text);;) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n\v\f"), text.size()));
    if (!text.starts_with('#') && !text.starts_with(';') && !text.starts_with("//")) return text;
    text.remove_prefix(std::min(text.find_first_of("\r\n"), text.size()));
  }
}

std::string_view first_word(std::string_view text) {
  return text.substr(0, text.find_first_of(" \t\r\n\v\f"));
}

bool is_text_stl(std::string_view bytes) {
  // A binary file may also begin with "solid", so first compare its length with its number of
  // triangles. If the file was cut short, look for bytes that never occur in text.
  if (bytes.size() >= kStlHeader) {
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + kStlCountAt, sizeof count);
    if (bytes.size() == kStlHeader + kStlRecord * std::size_t{count}) return false;
  }
  constexpr std::size_t kLooked = 512;
  const auto is_of_text = [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 || (c >= '\t' && c <= '\r');
  };
  const std::string_view first = first_word(without_first_lines(bytes));
  return (is_word(first, "solid") || is_word(first, "facet")) &&
         std::ranges::all_of(bytes.substr(0, kLooked), is_of_text);
}

TriangleSoup parse_binary_stl(std::string_view bytes, const std::string& name, double scale) {
  static_assert(std::endian::native == std::endian::little);
  constexpr std::size_t kHeader = kStlHeader, kRecord = kStlRecord, kCountAt = kStlCountAt,
                        kNormal = 12, kPoint = 12;
  if (bytes.size() < kHeader)
    throw FileError(name + ": byte " + std::to_string(bytes.size()) +
                    ": the file ends within its header; it is no STL file, or was cut short");
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kCountAt, sizeof count);
  if (bytes.size() < kHeader + kRecord * std::size_t{count})
    throw FileError(name + ": byte " + std::to_string(bytes.size()) +
                    ": the file ends before its " + std::to_string(count) +
                    " triangles do; it was cut short, copy it anew");
  TriangleSoup soup;
  soup.vertices.reserve(3 * std::size_t{count});
  soup.triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    const std::size_t record = kHeader + kRecord * t + kNormal;
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::array<float, 3> v{};
      std::memcpy(v.data(), bytes.data() + record + kPoint * corner, sizeof v);
      soup.vertices.emplace_back(v[0], v[1], v[2]);
      if (const auto broken = broken_vertex(soup.vertices.size(), soup.vertices.back(), scale))
        throw FileError(name + ": byte " + std::to_string(record + kPoint * corner) + ": " +
                        *broken);
    }
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

/// Reads the next three words as a vertex.
void add_vertex(TokenReader& words, const char* what, double scale, TriangleSoup& soup) {
  soup.vertices.push_back(words.vector(what));
  if (const auto broken = broken_vertex(soup.vertices.size(), soup.vertices.back(), scale))
    words.fail(*broken);
}

/// Skips the normal of a facet, because the order of the corners defines the outside.
void skip_normal(TokenReader& words) {
  if (!is_word(words.word(), "normal")) return words.end_line();
  for (int i = 0; i < 3; ++i) words.word();
}

TriangleSoup parse_text_stl(std::string_view bytes, const std::string& name, double scale) {
  TriangleSoup soup;
  TokenReader words(without_byte_order_mark(bytes), name);
  std::vector<std::uint32_t> loop;
  bool in_loop = false, begun = false;
  while (words.next_line()) {
    const char first = words.rest().front();
    if (!begun && (first == '#' || first == ';' || words.rest().starts_with("//"))) continue;
    begun = true;
    while (!words.line_ended()) {
      const std::string_view word = words.word();
      if (is_word(word, "vertex")) {
        if (!in_loop) words.fail("vertex: stands outside of a loop; export the surface anew");
        loop.push_back(static_cast<std::uint32_t>(soup.vertices.size()));
        add_vertex(words, "vertex", scale, soup);
      } else if (is_word(word, "outer")) {
        if (in_loop) words.fail("outer loop: the loop before it has no end; export it anew");
        loop.clear();
        in_loop = true;
      } else if (is_word(word, "endloop")) {
        if (!in_loop || loop.size() < 3)
          words.fail("endloop: a face needs three vertices, has " + std::to_string(loop.size()) +
                     "; export the surface anew");
        mesh_text::add_fan(loop, soup.triangles);
        in_loop = false;
      } else if (is_word(word, "facet")) {
        skip_normal(words);
      } else if (is_word(word, "solid") || is_word(word, "endsolid")) {
        words.end_line();  // This skips the name of the solid.
      } else if (!is_word(word, "endfacet") && !is_word(word, "loop")) {
        words.fail(TokenReader::shown(word) +
                   ": is no word of an STL file; export the surface anew");
      }
    }
  }
  if (in_loop) words.fail("the file ends within a face; it was cut short, copy it anew");
  return soup;
}

/// Refuses a file whose first word belongs to another format than its name.
void check_ending(std::string_view bytes, const std::string& name, std::string_view format) {
  const std::string_view text = without_first_lines(bytes);
  const auto refuse = [&](const char* what, const char* end) {
    throw FileError(name + ": is " + what +
                    " by its first word, its name ends otherwise; rename it to " + end);
  };
  if (format != ".ply" && is_word(first_word(text), "ply")) refuse("a PLY file", ".ply");
  if (format != ".stl" && is_word(first_word(text), "solid")) refuse("an STL file", ".stl");
}

std::string ending(const std::string& name) {
  std::string end = std::filesystem::path(name).extension().string();
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return end;
}

}  // namespace

TriangleSoup parse_obj(std::string_view bytes, const std::string& name, double scale) {
  TriangleSoup soup;
  TokenReader words(without_byte_order_mark(bytes), name, true);
  ObjIndices indices(words);
  std::vector<std::uint32_t> corners;
  while (words.next_line()) {
    if (words.rest().front() == '#') {
      words.end_line();
      continue;
    }
    const std::string_view word = words.word();
    if (is_word(word, "v")) {
      if (soup.vertices.size() >= kMostVertices) words.fail("v: too many vertices; simplify it");
      add_vertex(words, "v", scale, soup);  // A weight or a colour may follow.
    } else if (is_word(word, "f") || is_word(word, "fo")) {
      corners.clear();
      while (!words.line_ended() && words.rest().front() != '#')
        corners.push_back(indices.read(words.word(), soup.vertices.size()));
      if (!words.line_ended()) words.end_line();
      if (corners.size() < 3)
        words.fail("f: a face needs three vertices, has " + std::to_string(corners.size()) +
                   "; export the surface anew");
      mesh_text::add_fan(corners, soup.triangles);
    } else if (!is_no_surface(word)) {
      words.fail(TokenReader::shown(word) +
                 ": is nothing that can be touched; export triangles or polygons only");
    }
  }
  indices.check(soup.vertices.size());
  return soup;
}

TriangleSoup parse_stl(std::string_view bytes, const std::string& name, double scale) {
  return is_text_stl(bytes) ? parse_text_stl(bytes, name, scale)
                            : parse_binary_stl(bytes, name, scale);
}

TriangleSoup parse_mesh(std::string_view bytes, const std::string& name, double scale) {
  const std::string format = ending(name);
  if (const auto foreign = foreign_content(bytes)) throw FileError(name + ": " + *foreign);
  TriangleSoup soup;
  check_ending(bytes, name, format);
  if (format == ".obj")
    soup = parse_obj(bytes, name, scale);
  else if (format == ".stl")
    soup = parse_stl(bytes, name, scale);
  else if (format == ".ply")
    soup = parse_ply(bytes, name, scale);
  else
    throw FileError(name + ": is no mesh file by its ending; give .obj, .stl or .ply");
  if (soup.triangles.empty())
    throw FileError(name + ": there is no triangle in it; give a surface");
  for (Vec3& v : soup.vertices) v *= scale;
  return soup;
}

TriangleSoup read_mesh(const std::filesystem::path& file, double scale) {
  constexpr std::size_t kLargest = std::size_t{2} << 30;  // [bytes] about 40 million faces
  const std::string bytes =
      read_regular_file(file, kLargest, "check the path, it is relative to the scene's file");
  return parse_mesh(bytes, file.string(), scale);
}

std::string obj_text(const TriangleSoup& soup) {
  std::string out;
  const auto number = [&](auto value) {
    std::array<char, 32> text{};
    out += ' ';
    out.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr);
  };
  for (const Vec3& v : soup.vertices) {
    out += 'v';
    for (const double x : v) number(x);
    out += '\n';
  }
  for (const Triangle& t : soup.triangles) {
    out += 'f';
    for (const std::uint32_t i : t) number(i + 1);
    out += '\n';
  }
  return out;
}

}  // namespace feltwire
