#pragma once
// Choices with names: the values of an enum with a list of their names, or entries of a table that
// contain them. `name` returns the name of an entry; in a list of names it is the entry itself.

#include <cstddef>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

namespace feltwire {

/// The names as one text: "lan|wan|thin".
template <class Entries, class Name = std::identity>
std::string joined_names(const Entries& entries, std::string_view between = "|", Name name = {}) {
  std::string text;
  for (const auto& entry : entries)
    text.append(text.empty() ? "" : between).append(std::invoke(name, entry));
  return text;
}

/// Returns the entry with that name. Null if there is none.
template <class Entries, class Name = std::identity>
constexpr auto find_named(const Entries& entries, std::string_view given, Name name = {}) noexcept
    -> decltype(std::data(entries)) {
  for (const auto& entry : entries)
    if (std::invoke(name, entry) == given) return &entry;
  return nullptr;
}

/// Returns the entry with that name. If there is none, throws std::invalid_argument that lists the
/// choices. `what` names the kind of choice.
template <class Entries, class Name = std::identity>
const auto& get_named(std::string_view what, std::string_view given, const Entries& entries,
                      Name name = {}) {
  if (const auto* found = find_named(entries, given, name)) return *found;
  throw std::invalid_argument(std::string("unknown ").append(what).append(" '").append(given) +
                              "'; choose one of: " + joined_names(entries, " ", name));
}

/// Returns the value of an enum whose names are in the order of its values, from 0. Throws the same
/// as get_named().
template <class Enum, class Names>
Enum enum_from_name(std::string_view what, std::string_view given, const Names& names) {
  return static_cast<Enum>(&get_named(what, given, names) - std::data(names));
}

/// Returns the name of such a value. A value from outside may have none.
template <class Names, class Enum>
constexpr typename Names::value_type enum_name(const Names& names, Enum value) noexcept {
  const auto place = static_cast<std::size_t>(value);
  return place < names.size() ? names[place] : "unknown";
}

}  // namespace feltwire
