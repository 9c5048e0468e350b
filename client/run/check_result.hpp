#pragma once
// The results of a check. Each has a measured figure, a verdict and a remedy.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/net/real_time.hpp"

namespace feltwire {

enum class Verdict : std::uint8_t {
  pass,
  warn,  // it works, and the hand may feel it now and then
  fail   // forces will be late, faded or missing
};
std::string_view name(Verdict verdict);

struct CheckResult {
  std::string_view what;  // "rate"
  Verdict verdict = Verdict::pass;
  std::string figure;  // the measured value, with its unit
  std::string remedy;  // empty where it passes
};

/// Passes up to the first limit and fails above the second.
Verdict rising(double value, double passes, double works);
/// Makes a result. A result that passes gets no remedy.
CheckResult check_result(std::string_view what, Verdict verdict, std::string figure,
                         std::string remedy);
/// The number as text, with `digits` behind the point.
std::string figure(double value, int digits);
/// The result about the real-time rights of the servo's thread.
CheckResult permissions(RealTime granted);

/// The worst of them; pass if there is none.
Verdict worst(const std::vector<CheckResult>& results);
/// A line each, and its remedy below it.
std::string table(const std::vector<CheckResult>& results);
/// A JSON list, for the report.
std::string json(const std::vector<CheckResult>& results);

}  // namespace feltwire
