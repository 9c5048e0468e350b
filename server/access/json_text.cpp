#include "server/access/json_text.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/written_number.hpp"

namespace feltwire::json_text {
namespace {

/// Joins the entries between `begin` and `end`. Each entry begins on its own line, and all its
/// lines are indented by two columns.
std::string between(char begin, const std::vector<std::string>& entries, char end) {
  std::string result(1, begin);
  for (const std::string& entry : entries) {
    result += result.size() > 1 ? ",\n  " : "\n  ";
    for (const char c : entry) {
      result += c;
      if (c == '\n') result += "  ";
    }
  }
  if (!entries.empty()) result += '\n';
  return result += end;
}

}  // namespace

std::string text(std::string_view text) {
  using Json = nlohmann::json;  // its destructor allocates nothing if it holds a string
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string number(double value) { return std::isfinite(value) ? shortest_text(value) : "null"; }

std::string object(const std::vector<Member>& members) {
  std::vector<std::string> entries;
  entries.reserve(members.size());
  for (const auto& [name, value] : members) entries.push_back(text(name) + ": " + value);
  return between('{', entries, '}');
}

std::string list(const std::vector<std::string>& entries) { return between('[', entries, ']'); }

}  // namespace feltwire::json_text
