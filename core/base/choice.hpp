#pragma once
// Choices that have names: the values of an enum beside the list of their names, or entries of a
// table that have theirs. `name` says where an entry has its name; in a list of names, it is it.

#include <cstddef>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

namespace feltwire {

/// The names, for a text: "lan|wan|thin".
template <class Entries, class Name = std::identity>
std::string choices(const Entries& entries, std::string_view between = "|", Name name = {}) {
  std::string text;
  for (const auto& entry : entries)
    text.append(text.empty() ? "" : between).append(std::invoke(name, entry));
  return text;
}

/// The entry of that name; null where there is none.
template <class Entries, class Name = std::identity>
constexpr auto find_choice(const Entries& entries, std::string_view given, Name name = {}) noexcept
    -> decltype(std::data(entries)) {
  for (const auto& entry : entries)
    if (std::invoke(name, entry) == given) return &entry;
  return nullptr;
}

/// The same, of `what` they are. Throws std::invalid_argument naming the choices where there is
/// none.
template <class Entries, class Name = std::identity>
const auto& chosen(std::string_view what, std::string_view given, const Entries& entries,
                   Name name = {}) {
  if (const auto* found = find_choice(entries, given, name)) return *found;
  throw std::invalid_argument(std::string("unknown ").append(what).append(" '").append(given) +
                              "'; choose one of: " + choices(entries, " ", name));
}

/// The value of an enum whose names stand in the order of its values, which begin at 0. Throws as
/// chosen() does.
template <class Enum, class Names>
Enum chosen_value(std::string_view what, std::string_view given, const Names& names) {
  return static_cast<Enum>(&chosen(what, given, names) - std::data(names));
}

/// The name of such a value, which may come from outside and have none.
template <class Names, class Enum>
constexpr typename Names::value_type name_among(const Names& names, Enum value) noexcept {
  const auto place = static_cast<std::size_t>(value);
  return place < names.size() ? names[place] : "unknown";
}

}  // namespace feltwire
