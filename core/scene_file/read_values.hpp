#pragma once
// Internal to the readers of a scene file: values that several of its tables have.

#include <limits>
#include <optional>
#include <string>
#include <unordered_map>

#include "core/scene/validation.hpp"
#include "core/scene_file/scene_generated.h"

namespace feltwire {

inline std::string element(const char* list, std::size_t index) {
  return std::string(list) + "[" + std::to_string(index) + "]";
}

/// Throws FileError if a rule is broken. The violation's field is relative to `path`.
inline void require(const JsonDocument& document, const std::string& path,
                    const MaybeViolation& violation) {
  if (violation)
    document.fail(path.empty() ? violation->field : path + "." + violation->field,
                  violation->message);
}

/// The names in one list of the file. A scene may have some 100000 objects, so a name is found by
/// its hash.
class Names {
 public:
  Names(const JsonDocument& document, const char* list) : document_(document), list_(list) {}

  /// Adds the next name of the list. Throws FileError if it breaks a rule or is there already.
  void add(const std::string& name) {
    const std::string path = element(list_, places_.size());
    require(document_, path, broken_name(name));
    const auto [at, is_new] = places_.emplace(name, places_.size());
    if (!is_new)
      document_.fail(path + ".name", "'" + name + "' is the name of " + element(list_, at->second) +
                                         " too; rename one");
  }
  /// Its index in the list.
  std::optional<std::size_t> find(const std::string& name) const {
    const auto at = places_.find(name);
    if (at == places_.end()) return std::nullopt;
    return at->second;
  }

 private:
  const JsonDocument& document_;
  const char* list_;
  std::unordered_map<std::string, std::size_t> places_;
};

inline Vec3 vector(const scene_file::Vector& v) { return {v.x(), v.y(), v.z()}; }

/// Unchecked, not normalized.
inline Quaternion quaternion(const scene_file::Quaternion& q) {
  return Quaternion(q.w(), q.x(), q.y(), q.z());
}

/// The `position` and `orientation` of a table, unchecked.
template <class Table>
Pose pose_of(const Table& table) {
  Pose pose;
  if (const auto* p = table.position()) pose.position = vector(*p);
  if (const auto* q = table.orientation()) pose.orientation = quaternion(*q);
  return pose;
}

/// Calls take(name, primitive) for each primitive that the table at `path` has. Each primitive says
/// its own name; the schema says which tables may have which. Throws FileError if a length of
/// several parts is missing; a missing number is NaN.
template <class Take>
void take_primitives(const JsonDocument& document, const std::string& path, Take take) {
  Primitives::for_each([&](auto primitive) {
    const std::string at = path + "." + primitive.kName;
    if (!document.has(at)) return;
    primitive.lengths(primitive, [&](const Length& length, double& value) {
      const std::string name = length.name;
      const std::string field = at + "." + name.substr(0, name.find('.'));
      if (name.find('.') != std::string::npos && !document.has(field))
        document.fail(field, "is missing; give [x, y, z] in metres");
      const auto given = document.number(at + "." + name);
      value = length.share * given.value_or(std::numeric_limits<double>::quiet_NaN());
    });
    take(primitive.kName, primitive);
  });
}

}  // namespace feltwire
