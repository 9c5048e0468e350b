#pragma once
// Values of the reports that a task may not have.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/text.hpp"

namespace feltwire::teleop {

/// null if there is none.
inline nlohmann::ordered_json or_null(const std::optional<double>& measured, double scale = 1.0) {
  return measured ? nlohmann::ordered_json(*measured * scale) : nlohmann::ordered_json(nullptr);
}

/// A number in a column of this width; - if there is none.
inline std::string cell(int width, int digits, const std::optional<double>& measured,
                        double scale = 1.0) {
  std::string text;
  if (measured)
    append(text, "%*.*f", width, digits, *measured * scale);
  else
    append(text, "%*s", width, "-");
  return text;
}

}  // namespace feltwire::teleop
