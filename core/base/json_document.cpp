#include "core/base/json_document.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/base/json_outline.hpp"
#include "core/base/regular_file.hpp"
#include "flatbuffers/idl.h"

namespace feltwire {
namespace {

using json::Node;
using Kind = Node::Kind;

constexpr std::size_t kMaxFile = std::size_t{16} << 20;  // [bytes]

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

const Node* member(const Node& object, std::string_view key) {
  for (const Node& child : object.children)
    if (child.key == key) return &child;
  return nullptr;
}

/// Down a path as far as it is in the text; what is not stays in `path`.
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

/// The shape of the text against the schema, so that every error has its field and its line.
class SchemaCheck {
 public:
  explicit SchemaCheck(const std::string& file) : file_(file) {}

  void object(Node& node, const flatbuffers::StructDef& definition, const std::string& path) const {
    const auto& fields = definition.fields.vec;
    const std::string prefix = path.empty() ? "" : path + ".";
    if (definition.fixed && node.kind == Kind::array) {
      if (node.children.size() != fields.size())
        fail(node, path,
             "must have " + std::to_string(fields.size()) + " elements, is " + describe(node) +
                 "; give [" + names_of(fields) + "]");
      for (std::size_t i = 0; i < fields.size(); ++i) {
        node.children[i].key = fields[i]->name;  // so that line_of() finds "position.y"
        value(node.children[i], fields[i]->value.type, prefix + fields[i]->name);
      }
      return;
    }
    if (node.kind != Kind::object)
      fail(node, path, "must be an object, is " + describe(node) + "; write { ... }");
    for (Node& child : node.children) {
      const flatbuffers::FieldDef* field = definition.fields.Lookup(child.key);
      if (!field || field->deprecated)
        fail(child, prefix + json::shown(child.key),
             "is no field here; the fields are: " + names_of(fields));
      value(child, field->value.type, prefix + child.key);
    }
    for (const flatbuffers::FieldDef* field : fields)
      if ((field->IsRequired() || definition.fixed) && !member(node, field->name))
        fail(node, prefix + field->name, "is missing; add it");
  }

 private:
  [[noreturn]] void fail(const Node& node, const std::string& path, const std::string& why) const {
    throw FileError(json::error_text(file_, node.line, path, why));
  }

  void value(Node& node, const flatbuffers::Type& type, const std::string& path) const {
    using namespace flatbuffers;
    if (type.base_type == BASE_TYPE_STRUCT) {
      object(node, *type.struct_def, path);
    } else if (type.base_type == BASE_TYPE_VECTOR) {
      if (node.kind != Kind::array)
        fail(node, path, "must be a list, is " + describe(node) + "; write [ ... ]");
      for (std::size_t i = 0; i < node.children.size(); ++i)
        value(node.children[i], type.VectorType(), path + "[" + std::to_string(i) + "]");
    } else if (type.base_type == BASE_TYPE_STRING) {
      if (node.kind != Kind::string)
        fail(node, path, "must be a text, is " + describe(node) + "; put it in quotes");
    } else if (type.enum_def && type.base_type != BASE_TYPE_UNION) {
      if (node.kind != Kind::string || !type.enum_def->Lookup(node.text))
        fail(node, path,
             "must be one of: " + names_of(type.enum_def->Vals()) + "; is " + describe(node));
    } else if (type.base_type == BASE_TYPE_BOOL) {
      if (node.kind != Kind::word || (node.text != "true" && node.text != "false"))
        fail(node, path, "must be true or false, is " + describe(node) + "; write one of them");
    } else if (IsScalar(type.base_type)) {
      number(node, type.base_type, path);
    }
  }

  void number(const Node& node, flatbuffers::BaseType type, const std::string& path) const {
    if (node.kind != Kind::number)
      fail(node, path, "must be a number, is " + describe(node) + "; write it plainly, like 12.5");
    if (type == flatbuffers::BASE_TYPE_FLOAT &&
        std::abs(node.number) > std::numeric_limits<float>::max())
      fail(node, path, "is too large, " + describe(node) + "; lower it");
    if (!flatbuffers::IsInteger(type)) return;
    if (node.text.find_first_of(".eE") != std::string::npos)
      fail(node, path, "must be a whole number, is " + describe(node) + "; round it");
    const int unused_bits = 64 - 8 * static_cast<int>(flatbuffers::SizeOf(type));
    if (flatbuffers::IsUnsigned(type)) {
      whole<std::uint64_t>(node, path, 0, std::numeric_limits<std::uint64_t>::max() >> unused_bits);
    } else {
      const std::int64_t most = std::numeric_limits<std::int64_t>::max() >> unused_bits;
      whole<std::int64_t>(node, path, -most - 1, most);
    }
  }

  template <class Integer>
  void whole(const Node& node, const std::string& path, Integer least, Integer most) const {
    Integer value = 0;
    const char* end = node.text.data() + node.text.size();
    const auto read = std::from_chars(node.text.data(), end, value);
    if (read.ec != std::errc{} || read.ptr != end || value < least || value > most)
      fail(node, path,
           "does not fit, is " + describe(node) + "; choose a number from " +
               std::to_string(least) + " to " + std::to_string(most));
  }

  const std::string& file_;
};

/// The path of the last value that begins on or before `line`.
void last_path(const Node& node, int line, const std::string& path, std::string& found) {
  if (node.line > line) return;
  found = path;
  for (std::size_t i = 0; i < node.children.size(); ++i) {
    const Node& child = node.children[i];
    last_path(child, line,
              node.kind == Kind::array ? path + "[" + std::to_string(i) + "]"
              : path.empty()           ? child.key
                                       : path + "." + child.key,
              found);
  }
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  return read_regular_file(file, kMaxFile, "check the path and your right to read it");
}

struct JsonDocument::Parsed {
  std::string file;
  Node root;
  std::unique_ptr<flatbuffers::Parser> parser = std::make_unique<flatbuffers::Parser>();

  /// FlatBuffers 2.0.8 frees a value of an enumeration twice in the parser's destructor where
  /// memory was refused while that value was entered. A parser that was interrupted is not
  /// destroyed, then; its memory is lost.
  template <class Work>
  bool parse(Work work) {
    try {
      return work(*parser);
    } catch (...) {
      static_cast<void>(parser.release());
      throw;
    }
  }
};

JsonDocument::JsonDocument(std::string_view text, std::string file, const char* schema)
    : parsed_(std::make_unique<Parsed>()) {
  Parsed& p = *parsed_;
  p.file = std::move(file);
  const auto good_schema = [&](auto& parser) { return parser.Parse(schema); };
  if (!p.parse(good_schema) || !p.parser->root_struct_def_)
    throw std::logic_error("the schema for " + p.file + " is wrong: " + p.parser->error_);
  p.root = json::outline(text, p.file);
  SchemaCheck(p.file).object(p.root, *p.parser->root_struct_def_, "");

  // What is left to FlatBuffers to refuse (halves of surrogate pairs) it says as "12: 5: error:
  // ...".
  const std::string terminated(text);
  if (p.parse([&](auto& parser) { return parser.ParseJson(terminated.c_str()); })) return;
  const std::string& error = p.parser->error_;
  const int line = std::max(1, std::atoi(error.c_str()));
  const auto at = error.find("error: ");
  std::string field;
  last_path(p.root, line, "", field);
  throw FileError(json::error_text(
      p.file, line, field,
      (at == std::string::npos ? error : error.substr(at + 7)) + "; correct the text"));
}

JsonDocument::~JsonDocument() = default;

const std::uint8_t* JsonDocument::buffer() const {
  return parsed_->parser->builder_.GetBufferPointer();
}

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
