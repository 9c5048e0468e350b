#pragma once
// Values of a report: a number that is missing or not finite is null.

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/histogram.hpp"
#include "core/base/units.hpp"

namespace feltwire::report {

using Json = nlohmann::ordered_json;

inline Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
inline Json number(const std::optional<double>& value) {
  return value ? number(*value) : Json(nullptr);
}

inline Json micrometres(const std::optional<double>& metres) {
  return metres ? number(kMicro * *metres) : Json(nullptr);
}

/// Returns a quantile, or null without data, because zero would look like a measurement.
inline Json quantile(const Histogram& h, double q, double scale) {
  return h.count() > 0 ? number(scale * h.quantile(q)) : Json(nullptr);
}
inline Json max_of(const Histogram& h, double scale) {
  return h.count() > 0 ? number(scale * static_cast<double>(h.max())) : Json(nullptr);
}
inline Json mean_of(const Histogram& h, double scale) {
  return h.count() > 0 ? number(scale * h.mean()) : Json(nullptr);
}

/// Times [ns] in [us].
inline Json times(const Histogram& h) {
  constexpr double kMicroseconds = 1e-3;
  return {{"p50", quantile(h, 0.5, kMicroseconds)},
          {"p99", quantile(h, 0.99, kMicroseconds)},
          {"p999", quantile(h, 0.999, kMicroseconds)},
          {"max", max_of(h, kMicroseconds)}};
}

inline Json text_or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

}  // namespace feltwire::report
