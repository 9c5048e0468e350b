#include "client/run/finding.hpp"

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

Finding found(std::string_view what, Verdict verdict, std::string figure, std::string remedy) {
  if (verdict == Verdict::pass) remedy.clear();
  return {what, verdict, std::move(figure), std::move(remedy)};
}

Finding permissions(RealTime granted) {
  const std::string less = missing(granted, kServoPriority);
  return found("permissions", less.empty() ? Verdict::pass : Verdict::warn,
               std::string("real-time scheduling ") + (granted.scheduler ? "yes" : "no") +
                   ", memory locked " + (granted.memory_locked ? "yes" : "no"),
               less);
}

Verdict worst(const std::vector<Finding>& findings) {
  const auto found = std::ranges::max_element(findings, {}, &Finding::verdict);
  return found == findings.end() ? Verdict::pass : found->verdict;
}

std::string table(const std::vector<Finding>& findings) {
  constexpr std::size_t kWidth = 14;
  std::string text;
  for (const Finding& finding : findings) {
    std::string what(finding.what);
    what.resize(std::max(kWidth, what.size()), ' ');
    text += std::string(name(finding.verdict)) + "  " + what + "  " + finding.figure + "\n";
    if (!finding.remedy.empty()) text += "      remedy: " + finding.remedy + "\n";
  }
  return text;
}

std::string json(const std::vector<Finding>& findings) {
  auto list = nlohmann::ordered_json::array();
  for (const Finding& finding : findings)
    list.push_back({{"what", finding.what},
                    {"verdict", name(finding.verdict)},
                    {"figure", finding.figure},
                    {"remedy", finding.remedy}});
  return list.dump();
}

}  // namespace feltwire
