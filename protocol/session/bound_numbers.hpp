#pragma once
// The numbers of a session's bound, by name, for messages in text.

#include <array>
#include <optional>
#include <string_view>
#include <variant>

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

struct BoundNumber {
  std::string_view name;
  std::variant<double SessionParameters::*, std::optional<double> SessionParameters::*> value;
};

inline constexpr std::array<BoundNumber, 7> kBoundNumbers = {{
    {"operator_damping", &SessionParameters::operator_damping},      // [N s/m]
    {"velocity_cutoff", &SessionParameters::velocity_cutoff},        // [Hz]
    {"c1", &SessionParameters::c1},                                  // [N/m]
    {"c2", &SessionParameters::c2},                                  // [N/m]
    {"coupling_stiffness", &SessionParameters::coupling_stiffness},  // [N/m]
    {"coupling_damping", &SessionParameters::coupling_damping},      // [N s/m]
    {"tool_mass", &SessionParameters::tool_mass},                    // [kg]
}};

/// Empty: the default of the session's device.
inline std::optional<double> value_of(const BoundNumber& number,
                                      const SessionParameters& parameters) {
  return std::visit([&](auto field) { return std::optional<double>(parameters.*field); },
                    number.value);
}
inline void set(const BoundNumber& number, SessionParameters& parameters, double value) {
  std::visit([&](auto field) { parameters.*field = value; }, number.value);
}

}  // namespace feltwire
