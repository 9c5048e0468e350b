#include "client/run/check_result.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

namespace feltwire {
namespace {

constexpr std::array<std::string_view, 3> kVerdicts = {"pass", "warn", "fail"};

}  // namespace

std::string_view name(Verdict verdict) { return kVerdicts[static_cast<std::size_t>(verdict)]; }

std::string figure(double value, int digits) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", digits, value);
  return text.data();
}

Verdict rising(double value, double passes, double works) {
  if (!(value <= works)) return Verdict::fail;
  return value <= passes ? Verdict::pass : Verdict::warn;
}

CheckResult check_result(std::string_view what, Verdict verdict, std::string figure,
                         std::string remedy) {
  if (verdict == Verdict::pass) remedy.clear();
  return {what, verdict, std::move(figure), std::move(remedy)};
}

CheckResult permissions(RealTime granted) {
  const std::string less = missing(granted, kServoPriority);
  return check_result("permissions", less.empty() ? Verdict::pass : Verdict::warn,
                      std::string("real-time scheduling ") + (granted.scheduler ? "yes" : "no") +
                          ", memory locked " + (granted.memory_locked ? "yes" : "no"),
                      less);
}

Verdict worst(const std::vector<CheckResult>& results) {
  const auto found = std::ranges::max_element(results, {}, &CheckResult::verdict);
  return found == results.end() ? Verdict::pass : found->verdict;
}

std::string table(const std::vector<CheckResult>& results) {
  constexpr std::size_t kWidth = 14;
  std::string text;
  for (const CheckResult& result : results) {
    std::string what(result.what);
    what.resize(std::max(kWidth, what.size()), ' ');
    text += std::string(name(result.verdict)) + "  " + what + "  " + result.figure + "\n";
    if (!result.remedy.empty()) text += "      remedy: " + result.remedy + "\n";
  }
  return text;
}

std::string json(const std::vector<CheckResult>& results) {
  auto list = nlohmann::ordered_json::array();
  for (const CheckResult& result : results)
    list.push_back({{"what", result.what},
                    {"verdict", name(result.verdict)},
                    {"figure", result.figure},
                    {"remedy", result.remedy}});
  return list.dump();
}

}  // namespace feltwire
