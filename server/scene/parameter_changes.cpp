#include "server/scene/parameter_changes.hpp"

#include <spdlog/fmt/fmt.h>

#include <tuple>

#include "protocol/session/grant.hpp"

namespace feltwire {
namespace {

template <class Value>
std::string word(const Value& value) {
  if constexpr (std::is_enum_v<Value>)
    return std::string(name(value));
  else
    return fmt::format("{}", value);
}
std::string word(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : "usual";
}

}  // namespace

std::string changes(const SessionParameters& before, const SessionParameters& after) {
  std::string text;
  const auto compare = [&](const auto& rule) {
    const auto &was = before.*rule.value, &is = after.*rule.value;
    if (was == is) return;
    text += fmt::format("{}{} {} -> {}", text.empty() ? "" : ", ", rule.field, word(was), word(is));
  };
  std::apply([&](const auto&... rules) { (compare(rules), ...); }, kParameterRules);
  return text.empty() ? "nothing changed" : text;
}

}  // namespace feltwire
