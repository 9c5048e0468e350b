#include "core/base/json_document.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/base/json_member.hpp"
#include "core/base/json_outline.hpp"
#include "core/base/regular_file.hpp"
#include "flatbuffers/idl.h"

namespace feltwire {
namespace {

using flatbuffers::FieldDef;
using flatbuffers::StructDef;
using flatbuffers::Type;
using json::Node;
using Kind = Node::Kind;

constexpr std::size_t kMaxFile = std::size_t{16} << 20;  // [bytes] largest accepted size of a file

std::string describe(const Node& node) {
  switch (node.kind) {
    case Kind::object:
      return "an object { }";
    case Kind::array:
      return "a list of " + std::to_string(node.children.size());
    case Kind::string:
      return "the text " + json::shown(node.text);
    default:
      return json::shown(node.text);
  }
}

template <class Definitions>
std::string names_of(const Definitions& definitions) {
  std::string names;
  for (const auto* definition : definitions)
    names += (names.empty() ? "" : ", ") + definition->name;
  return names;
}

/// Returns a text that shows how to write a table or a struct, with the names of its fields.
std::string notation(const StructDef& definition) {
  const auto& fields = definition.fields.vec;
  if (definition.fixed) return "[" + names_of(fields) + "]";
  std::string required;
  for (const FieldDef* field : fields)
    if (field->IsRequired())
      required += (required.empty() ? "" : ", ") + ('"' + field->name) + "\": ...";
  return "{ " + (required.empty() ? "..." : required) + " }" +
         (fields.empty() ? "; it has no field" : "; its fields are: " + names_of(fields));
}

const Node* member(const Node& object, std::string_view key) {
  for (const Node& child : object.children)
    if (child.key == key) return &child;
  return nullptr;
}

/// Follows a path through the document as far as the path exists. Returns the last node of this
/// part. Leaves the rest in `path`.
const Node& walk(const Node& root, std::string_view& path) {
  const Node* node = &root;
  while (!path.empty()) {
    const Node* child = nullptr;
    const std::size_t end = std::min(path.find_first_of(".[", 1), path.size());
    if (path.front() == '[') {
      const auto index = std::strtoul(std::string(path.substr(1, end - 1)).c_str(), nullptr, 10);
      if (node->kind == Kind::array && index < node->children.size())
        child = &node->children[index];
    } else {
      const std::size_t begin = path.front() == '.' ? 1 : 0;
      child = member(*node, path.substr(begin, end - begin));
    }
    if (!child) break;
    node = child;
    path.remove_prefix(end);
  }
  return *node;
}

/// Appends `written` to `text`, with the character in place of each escape sequence. Returns an
/// error text if one half of a surrogate pair is missing. Precondition: the JSON scanner has
/// accepted the escape sequences.
std::optional<std::string_view> unescape(std::string_view written, std::string& text) {
  constexpr std::string_view kUnpairedHigh = "illegal Unicode sequence (unpaired high surrogate)";
  constexpr std::uint32_t kHigh = 0xD800, kLow = 0xDC00, kEnd = 0xE000, kPairs = 0x10000;
  constexpr std::string_view kLetters = "bfnrt", kControls = "\b\f\n\r\t";
  std::uint32_t high = 0;  // first half of a surrogate pair, or 0
  for (std::size_t at = 0; at < written.size();) {
    const bool escape = written[at] == '\\';
    const char c = written[escape ? at + 1 : at];
    at += escape ? 2 : 1;
    if (!escape || c != 'u') {
      if (high != 0) return kUnpairedHigh;
      const std::size_t letter = escape ? kLetters.find(c) : std::string_view::npos;
      text += letter == std::string_view::npos ? c : kControls[letter];
      continue;
    }
    constexpr std::size_t kDigits = 4;
    constexpr int kHexadecimal = 16;
    std::uint32_t code = 0;
    std::from_chars(&written[at], &written[at] + kDigits, code, kHexadecimal);
    at += kDigits;
    const bool is_high = code >= kHigh && code < kLow, is_low = code >= kLow && code < kEnd;
    if (is_high && high != 0) return "illegal Unicode sequence (multiple high surrogates)";
    if (is_low && high == 0) return "illegal Unicode sequence (unpaired low surrogate)";
    if (!is_low && high != 0) return kUnpairedHigh;
    if (is_low) code = kPairs + ((high - kHigh) << 10) + (code - kLow);
    high = is_high ? code : 0;
    if (!is_high) flatbuffers::ToUTF8(code, &text);
  }
  if (high != 0) return kUnpairedHigh;
  return std::nullopt;
}

/// Checks the structure of a document against a schema, so that every error message names the field
/// and the line. Builds the FlatBuffer at the same time.
class Builder {
 public:
  explicit Builder(const std::string& file) : file_(file) {}

  flatbuffers::DetachedBuffer build(Node& root, const StructDef& definition) {
    buffer_.Finish(flatbuffers::Offset<void>(table(root, definition, "")));
    return buffer_.Release();
  }

 private:
  /// The value of a field or an element: its bytes, or the offset of its text, list or table.
  struct Value {
    std::vector<std::uint8_t> bytes;
    flatbuffers::uoffset_t offset = 0;  // 0 if the value has no text, list or table
  };

  [[noreturn]] void fail(const Node& node, const std::string& path, const std::string& why) const {
    throw FileError(json::error_text(file_, node.line, path, why));
  }

  flatbuffers::uoffset_t table(Node& node, const StructDef& definition, const std::string& path) {
    std::vector<std::pair<const FieldDef*, Value>> values;
    members(node, definition, path, [&](Node& child, const FieldDef& field, const auto& name) {
      values.emplace_back(&field, value(child, field.value.type, name));
    });
    const flatbuffers::uoffset_t start = buffer_.StartTable();
    for (const auto& [field, value] : values) {
      if (value.offset != 0) {
        buffer_.AddOffset(field->value.offset, flatbuffers::Offset<void>(value.offset));
        continue;
      }
      buffer_.Align(flatbuffers::InlineAlignment(field->value.type));
      buffer_.PushBytes(value.bytes.data(), value.bytes.size());
      buffer_.AddStructOffset(field->value.offset, buffer_.GetSize());
    }
    return buffer_.EndTable(start);
  }

  /// Reads a struct from an object or from a list of all fields, and writes it to `place`.
  void fixed(Node& node, const StructDef& definition, const std::string& path,
             std::uint8_t* place) const {
    const auto& fields = definition.fields.vec;
    if (node.kind == Kind::array) {
      if (node.children.size() != fields.size())
        fail(node, path,
             "must have " + std::to_string(fields.size()) + " elements, is " + describe(node) +
                 "; give [" + names_of(fields) + "]");
      for (std::size_t i = 0; i < fields.size(); ++i)
        node.children[i].key = fields[i]->name;  // With this key, line_of() finds "position.y".
    }
    members(node, definition, path, [&](Node& child, const FieldDef& field, const auto& name) {
      in_place(child, field.value.type, name, place + field.value.offset);
    });
  }

  /// Calls take(member, its field in the schema, its path) for each member of the node.
  template <class Take>
  void members(Node& node, const StructDef& definition, const std::string& path, Take take) const {
    const auto& fields = definition.fields.vec;
    const std::string prefix = path.empty() ? "" : path + ".";
    if (node.kind != Kind::object && !(definition.fixed && node.kind == Kind::array))
      fail(node, path,
           std::string(definition.fixed
                           ? "must be a list of " + std::to_string(fields.size()) + " numbers"
                           : "must be an object") +
               ", is " + describe(node) + "; write " + notation(definition));
    for (Node& child : node.children) {
      const FieldDef* field = definition.fields.Lookup(child.key);
      if (!field || field->deprecated)
        fail(child, prefix + json::shown(child.key),
             fields.empty() ? "is no field here; write { } without fields"
                            : "is no field here; the fields are: " + names_of(fields));
      take(child, *field, prefix + child.key);
    }
    for (const FieldDef* field : fields)
      if ((field->IsRequired() || definition.fixed) && !member(node, field->name))
        fail(node, prefix + field->name, "is missing; add it");
  }

  Value value(Node& node, const Type& type, const std::string& path) {
    if (type.base_type == flatbuffers::BASE_TYPE_STRUCT && !type.struct_def->fixed)
      return {{}, table(node, *type.struct_def, path)};
    if (type.base_type == flatbuffers::BASE_TYPE_VECTOR) return {{}, list(node, type, path)};
    if (type.base_type == flatbuffers::BASE_TYPE_STRING) return {{}, string(node, path)};
    Value value{std::vector<std::uint8_t>(flatbuffers::InlineSize(type))};
    in_place(node, type, path, value.bytes.data());
    return value;
  }

  flatbuffers::uoffset_t list(Node& node, const Type& type, const std::string& path) {
    const Type element = type.VectorType();
    if (node.kind != Kind::array)
      fail(node, path,
           "must be a list, is " + describe(node) + "; write [ " +
               (element.base_type == flatbuffers::BASE_TYPE_STRUCT
                    ? "... ], each as " + notation(*element.struct_def)
                    : "... ]"));
    const std::size_t count = node.children.size();
    std::vector<flatbuffers::Offset<void>> offsets;
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i < count; ++i) {
      const Value v = value(node.children[i], element, path + "[" + std::to_string(i) + "]");
      if (v.offset != 0) offsets.emplace_back(v.offset);
      bytes.insert(bytes.end(), v.bytes.begin(), v.bytes.end());
    }
    if (!offsets.empty()) return buffer_.CreateVector(offsets).o;
    const std::size_t alignment = flatbuffers::InlineAlignment(element);
    buffer_.StartVector(bytes.size() / alignment, alignment);
    buffer_.PushBytes(bytes.data(), bytes.size());
    return buffer_.EndVector(count);
  }

  flatbuffers::uoffset_t string(const Node& node, const std::string& path) {
    if (node.kind != Kind::string)
      fail(node, path, "must be a text, is " + describe(node) + "; put it in quotes");
    std::string text;
    if (const auto wrong = unescape(node.text, text))
      fail(node, path, std::string(*wrong) + "; correct the text");
    return buffer_.CreateString(text).o;
  }

  void in_place(Node& node, const Type& type, const std::string& path, std::uint8_t* place) const {
    using namespace flatbuffers;
    if (type.base_type == BASE_TYPE_STRUCT) {
      fixed(node, *type.struct_def, path, place);
    } else if (type.enum_def) {
      const EnumVal* named = node.kind == Kind::string ? type.enum_def->Lookup(node.text) : nullptr;
      if (!named)
        fail(node, path,
             "must be one of: " + names_of(type.enum_def->Vals()) + "; is " + describe(node));
      put(named->GetAsUInt64(), type.base_type, place);
    } else if (type.base_type == BASE_TYPE_BOOL) {
      if (node.kind != Kind::word || (node.text != "true" && node.text != "false"))
        fail(node, path, "must be true or false, is " + describe(node) + "; write one of them");
      put(node.text == "true" ? 1 : 0, type.base_type, place);
    } else {
      number(node, type.base_type, path, place);
    }
  }

  void number(const Node& node, flatbuffers::BaseType type, const std::string& path,
              std::uint8_t* place) const {
    if (node.kind != Kind::number)
      fail(node, path, "must be a number, is " + describe(node) + "; write it plainly, like 12.5");
    if (type == flatbuffers::BASE_TYPE_DOUBLE) return flatbuffers::WriteScalar(place, node.number);
    if (type == flatbuffers::BASE_TYPE_FLOAT) {
      if (std::abs(node.number) > std::numeric_limits<float>::max())
        fail(node, path, "is too large, " + describe(node) + "; lower it");
      return flatbuffers::WriteScalar(place, static_cast<float>(node.number));
    }
    if (node.text.find_first_of(".eE") != std::string::npos)
      fail(node, path, "must be a whole number, is " + describe(node) + "; round it");
    const int unused_bits = 64 - 8 * static_cast<int>(flatbuffers::SizeOf(type));
    if (flatbuffers::IsUnsigned(type)) {
      put(whole<std::uint64_t>(node, path, 0,
                               std::numeric_limits<std::uint64_t>::max() >> unused_bits),
          type, place);
    } else {
      const std::int64_t most = std::numeric_limits<std::int64_t>::max() >> unused_bits;
      put(static_cast<std::uint64_t>(whole<std::int64_t>(node, path, -most - 1, most)), type,
          place);
    }
  }

  template <class Integer>
  Integer whole(const Node& node, const std::string& path, Integer least, Integer most) const {
    Integer value = 0;
    const char* end = node.text.data() + node.text.size();
    const auto read = std::from_chars(node.text.data(), end, value);
    if (read.ec != std::errc{} || read.ptr != end || value < least || value > most)
      fail(node, path,
           "does not fit, is " + describe(node) + "; choose a number from " +
               std::to_string(least) + " to " + std::to_string(most));
    return value;
  }

  /// Writes an integer of this type to `place`, the lowest byte first.
  static void put(std::uint64_t value, flatbuffers::BaseType type, std::uint8_t* place) {
    for (std::size_t i = 0; i < flatbuffers::SizeOf(type); ++i, value >>= 8)
      place[i] = static_cast<std::uint8_t>(value);
  }

  const std::string& file_;
  flatbuffers::FlatBufferBuilder buffer_;
};

/// Parses a schema. If memory runs out while FlatBuffers 2.0.8 reads an enumeration value, the
/// destructor of the parser frees this value twice. So after an exception, this function does not
/// destroy the parser, and leaks its memory.
std::unique_ptr<flatbuffers::Parser> parsed_schema(const char* schema, const std::string& file) {
  auto parser = std::make_unique<flatbuffers::Parser>();
  bool good = false;
  try {
    good = parser->Parse(schema);
  } catch (...) {
    static_cast<void>(parser.release());
    throw;
  }
  if (!good || !parser->root_struct_def_)
    throw std::logic_error("the schema for " + file + " is wrong: " + parser->error_);
  return parser;
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  return read_regular_file(file, kMaxFile, "check the path and your right to read it");
}

std::optional<std::string> json_text_member(std::string_view json, std::string_view key) {
  try {
    const Node root = json::outline(json, "");
    const Node* node = root.kind == Kind::object ? member(root, key) : nullptr;
    std::string text;
    if (node == nullptr || node->kind != Kind::string || unescape(node->text, text))
      return std::nullopt;
    return text;
  } catch (const FileError&) {
    return std::nullopt;
  }
}

struct JsonDocument::Parsed {
  std::string file;
  Node root;
  flatbuffers::DetachedBuffer buffer;
};

JsonDocument::JsonDocument(std::string_view text, std::string file, const char* schema)
    : parsed_(std::make_unique<Parsed>()) {
  Parsed& p = *parsed_;
  p.file = std::move(file);
  const auto parser = parsed_schema(schema, p.file);
  p.root = json::outline(text, p.file);
  p.buffer = Builder(p.file).build(p.root, *parser->root_struct_def_);
}

JsonDocument::~JsonDocument() = default;

const std::uint8_t* JsonDocument::buffer() const { return parsed_->buffer.data(); }

bool JsonDocument::has(std::string_view path) const {
  walk(parsed_->root, path);
  return path.empty();
}

std::optional<double> JsonDocument::number(std::string_view path) const {
  const Node& node = walk(parsed_->root, path);
  if (!path.empty() || node.kind != Kind::number) return std::nullopt;
  return node.number;
}

int JsonDocument::line_of(std::string_view path) const { return walk(parsed_->root, path).line; }

void JsonDocument::fail(std::string_view path, std::string_view message) const {
  throw FileError(json::error_text(parsed_->file, line_of(path), path, message));
}

}  // namespace feltwire
