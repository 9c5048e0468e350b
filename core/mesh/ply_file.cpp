#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "core/base/foreign_content.hpp"
#include "core/mesh/mesh_file.hpp"
#include "core/mesh/mesh_text.hpp"

namespace feltwire {
namespace {

using mesh_text::is_word;
using mesh_text::TokenReader;

enum class Scalar : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
constexpr std::size_t kNotThere = std::numeric_limits<std::size_t>::max();

std::string in_small_letters(std::string_view text) {
  std::string small(text);
  for (char& c : small) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return small;
}

std::optional<Scalar> scalar_named(std::string_view name) {
  constexpr std::array<std::string_view, 8> kOld = {"char", "uchar", "short", "ushort",
                                                    "int",  "uint",  "float", "double"};
  constexpr std::array<std::string_view, 8> kNew = {"int8",  "uint8",  "int16",   "uint16",
                                                    "int32", "uint32", "float32", "float64"};
  for (std::size_t i = 0; i < kOld.size(); ++i)
    if (is_word(name, kOld[i]) || is_word(name, kNew[i])) return static_cast<Scalar>(i);
  return std::nullopt;
}

struct Property {
  std::string name;
  Scalar type = Scalar::f32;
  std::optional<Scalar> list;  // type of the list's length; no value if the property is no list
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;

  std::size_t find(std::initializer_list<std::string_view> names) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
      if (std::ranges::find(names, properties[i].name) != names.end()) return i;
    return kNotThere;
  }
};

enum class Format { text, little, big };
struct Header {
  Format format = Format::text;
  std::vector<Element> elements;
};

Scalar scalar(const TokenReader& words, std::string_view word) {
  const auto type = scalar_named(word);
  if (!type)
    words.fail("property: " + TokenReader::shown(word) + " is no type of PLY; export it anew");
  return *type;
}

Header read_header(TokenReader& words) {
  Header header;
  bool begun = words.next_line();
  while (begun && words.rest().front() == '#') begun = words.next_line();
  if (!begun || !is_word(words.word(), "ply"))
    words.fail("does not begin with 'ply'; it is no PLY file");
  bool format = false;
  while (words.next_line()) {
    const std::string_view word = words.word();
    if (is_word(word, "end_header")) {
      if (!format) words.fail("format: is missing; export the surface anew");
      return header;
    }
    if (is_word(word, "format")) {
      const std::string_view f = words.word();
      format = true;
      if (is_word(f, "binary_little_endian"))
        header.format = Format::little;
      else if (is_word(f, "binary_big_endian"))
        header.format = Format::big;
      else if (!is_word(f, "ascii"))
        words.fail("format: " + TokenReader::shown(f) +
                   " is unknown; export it as ascii or binary");
    } else if (is_word(word, "element")) {
      Element element{.name = in_small_letters(words.word()), .count = 0, .properties = {}};
      const long long count = words.whole(words.word(), "element");
      if (count < 0 || count >= std::numeric_limits<std::uint32_t>::max())
        words.fail("element: there cannot be " + std::to_string(count) + "; export it anew");
      element.count = static_cast<std::size_t>(count);
      header.elements.push_back(std::move(element));
    } else if (is_word(word, "property")) {
      if (header.elements.empty()) words.fail("property: of no element; export the surface anew");
      Property property;
      std::string_view type = words.word();
      if (is_word(type, "list")) {
        property.list = scalar(words, words.word());
        type = words.word();
      }
      property.type = scalar(words, type);
      property.name = in_small_letters(words.word());
      const bool coordinate = property.name == "x" || property.name == "y" || property.name == "z";
      if (property.list && coordinate && header.elements.back().name == "vertex")
        words.fail("property " + property.name +
                   ": is a list, must be one number; export the surface anew");
      header.elements.back().properties.push_back(std::move(property));
    } else if (!is_word(word, "comment") && !is_word(word, "obj_info")) {
      words.fail(TokenReader::shown(word) +
                 ": is no word of a PLY header; export the surface anew");
    }
  }
  words.fail("the file ends within its header; it was cut short, copy it anew");
}

/// Values of a text body. Each element has its own line.
class TextValues {
 public:
  explicit TextValues(TokenReader& words) : words_(words) {}
  [[noreturn]] void fail(const std::string& message) const { words_.fail(message); }
  void begin(const Element& element) {
    if (!words_.next_line())
      fail(element.name + ": the file ends before all are given; copy it anew");
  }
  double next(Scalar) { return words_.number("value"); }
  /// Returns an upper bound of a list's length: the rest of the file.
  std::size_t bound() const { return words_.rest().size(); }

 private:
  TokenReader& words_;
};

class BinaryValues {
 public:
  BinaryValues(std::string_view bytes, std::size_t at, bool big, const std::string& name)
      : bytes_(bytes), at_(std::min(at, bytes.size())), big_(big), name_(name) {}
  [[noreturn]] void fail(const std::string& message) const {
    throw FileError(name_ + ": byte " + std::to_string(at_) + ": " + message);
  }
  void begin(const Element&) {}
  double next(Scalar type) {
    switch (type) {
      case Scalar::i8:
        return take<std::int8_t>();
      case Scalar::u8:
        return take<std::uint8_t>();
      case Scalar::i16:
        return take<std::int16_t>();
      case Scalar::u16:
        return take<std::uint16_t>();
      case Scalar::i32:
        return take<std::int32_t>();
      case Scalar::u32:
        return take<std::uint32_t>();
      case Scalar::f32:
        return static_cast<double>(take<float>());
      case Scalar::f64:
        return take<double>();
    }
    return 0.0;
  }
  std::size_t bound() const { return bytes_.size() - at_; }

 private:
  template <class T>
  T take() {
    if (bytes_.size() - at_ < sizeof(T))
      fail("the file ends too early; it was cut short, copy it anew");
    std::array<char, sizeof(T)> raw{};
    std::copy_n(bytes_.data() + at_, sizeof(T), raw.data());
    at_ += sizeof(T);
    if (big_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  std::string_view bytes_;
  std::size_t at_;
  bool big_;
  const std::string& name_;
};

template <class Values>
void read_body(Values& values, const Header& header, double scale, TriangleSoup& soup) {
  std::vector<double> row;   // scalars of an element
  std::vector<double> list;  // values of the index list
  std::vector<std::uint32_t> corners;
  std::size_t vertices = 0;  // Faces may come before vertices.
  for (const Element& element : header.elements)
    if (element.name == "vertex") vertices += element.count;
  for (const Element& element : header.elements) {
    const bool vertex = element.name == "vertex", face = element.name == "face";
    const std::size_t x = element.find({"x"}), y = element.find({"y"}), z = element.find({"z"});
    const std::size_t indices = element.find({"vertex_indices", "vertex_index"});
    if (vertex && (x == kNotThere || y == kNotThere || z == kNotThere))
      values.fail("vertex: x, y or z is missing; export the surface anew");
    if (face && (indices == kNotThere || !element.properties[indices].list))
      values.fail("face: the list vertex_indices is missing; export the surface anew");
    if (element.properties.empty() && element.count > 0)
      values.fail(element.name + ": has no property; export the surface anew");
    if (element.name == "tristrips") values.fail("tristrips: strips are not read; export faces");
    row.resize(element.properties.size());
    for (std::size_t i = 0; i < element.count; ++i) {
      values.begin(element);
      for (std::size_t p = 0; p < element.properties.size(); ++p) {
        const Property& property = element.properties[p];
        if (!property.list) {
          row[p] = values.next(property.type);
          continue;
        }
        const double length = values.next(*property.list);
        if (!(length >= 0.0) || length > static_cast<double>(values.bound()))
          values.fail(property.name + ": a list cannot be that long; export the surface anew");
        const bool wanted = face && p == indices;
        if (wanted) list.clear();
        const auto count = static_cast<std::size_t>(std::ceil(length));
        for (std::size_t n = 0; n < count; ++n) {
          const double value = values.next(property.type);
          if (wanted) list.push_back(value);
        }
      }
      if (vertex) {
        soup.vertices.emplace_back(row[x], row[y], row[z]);
        if (const auto broken =
                mesh_text::broken_vertex(soup.vertices.size(), soup.vertices.back(), scale))
          values.fail(*broken);
      }
      if (!face) continue;
      if (list.size() < 3)
        values.fail("face: needs three vertices, has " + std::to_string(list.size()) +
                    "; export the surface anew");
      corners.clear();
      for (const double index : list) {
        if (!(index >= 0.0 && index < static_cast<double>(vertices)) || index != std::floor(index))
          values.fail("face: a vertex does not exist among the " + std::to_string(vertices) +
                      "; export the surface anew");
        corners.push_back(static_cast<std::uint32_t>(index));
      }
      mesh_text::add_fan(corners, soup.triangles);
    }
  }
}

}  // namespace

TriangleSoup parse_ply(std::string_view bytes, const std::string& name, double scale) {
  bytes = without_byte_order_mark(bytes);
  TokenReader words(bytes, name);
  const Header header = read_header(words);
  TriangleSoup soup;
  if (header.format == Format::text) {
    TextValues values(words);
    read_body(values, header, scale, soup);
  } else {
    BinaryValues values(bytes, words.at(), header.format == Format::big, name);
    read_body(values, header, scale, soup);
  }
  return soup;
}

}  // namespace feltwire
