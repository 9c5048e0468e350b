#include "server/access/json_text.hpp"

#include <nlohmann/json.hpp>

namespace feltwire::json_text {
namespace {

/// On lines of their own, each two columns further to the right.
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
  using Json = nlohmann::json;  // the destructor of one that is a text allocates nothing
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string number(double value) { return nlohmann::json(value).dump(); }

std::string object(const std::vector<Member>& members) {
  std::vector<std::string> entries;
  entries.reserve(members.size());
  for (const auto& [name, value] : members) entries.push_back(text(name) + ": " + value);
  return between('{', entries, '}');
}

std::string list(const std::vector<std::string>& entries) { return between('[', entries, ']'); }

}  // namespace feltwire::json_text
