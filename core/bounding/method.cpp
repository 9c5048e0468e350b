#include "core/bounding/method.hpp"

#include <algorithm>
#include <deque>
#include <stdexcept>

#include "core/bounding/built_in_methods.hpp"

namespace feltwire {
namespace {

std::deque<BoundingMethod>& registry() {
  static std::deque<BoundingMethod> methods = [] {
    const auto own = built_in_methods<double>();
    return std::deque<BoundingMethod>(own.begin(), own.end());
  }();
  return methods;
}

const BoundingMethod* find(std::string_view name) {
  const auto& all = registry();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const BoundingMethod& m) { return m.name == name; });
  return found == all.end() ? nullptr : &*found;
}

bool good_name(std::string_view name) {
  return !name.empty() && name.size() <= kLongestMethodName &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string_view::npos;
}

std::vector<std::string_view> names(bool research) {
  std::vector<std::string_view> found;
  for (const BoundingMethod& m : registry())
    if (m.research == research) found.push_back(m.name);
  return found;
}

}  // namespace

std::vector<const BoundingMethod*> bounding_methods() {
  std::vector<const BoundingMethod*> all;
  for (const BoundingMethod& m : registry()) all.push_back(&m);
  return all;
}

std::vector<std::string_view> bounding_method_names() {
  std::vector<std::string_view> all;
  for (const BoundingMethod& m : registry()) all.push_back(m.name);
  return all;
}

const BoundingMethod& bounding_method(std::string_view name) {
  if (const BoundingMethod* found = find(name)) return *found;
  throw std::invalid_argument("unknown bounding mode '" + std::string(name) +
                              "'; choose one of: " + joined_names(bounding_method_names(), " "));
}

void add_bounding_method(const BoundingMethod& method) {
  const std::string what = "bounding method '" + std::string(method.name) + "': ";
  if (!good_name(method.name))
    throw std::invalid_argument(what + "a name is 1 to " + std::to_string(kLongestMethodName) +
                                " of a to z, 0 to 9 and _");
  if (find(method.name) != nullptr)
    throw std::invalid_argument(what + "there is one of that name; take another");
  if (method.make == nullptr)
    throw std::invalid_argument(what + "its entry has no law; set `make`");
  registry().push_back(method);
}

std::string bounding_method_choices() {
  return joined_names(names(false)) + "; for research: " + joined_names(names(true));
}

std::string bounding_method_summaries() {
  std::size_t widest = 0;
  for (const std::string_view name : bounding_method_names())
    widest = std::max(widest, name.size());
  std::string text;
  for (const bool research : {false, true})
    for (const std::string_view name : names(research)) {
      text.append("  ").append(name).append(widest + 2 - name.size(), ' ');
      text.append(research ? "(research) " : "").append(bounding_method(name).summary) += '\n';
    }
  return text;
}

}  // namespace feltwire
