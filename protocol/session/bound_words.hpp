#pragma once
// An admin's words for the bound of a session, as parameters; and the numbers of a bound by name,
// for messages in text.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// Changes of a session's bound. Missing values stay.
struct BoundWords {
  std::optional<std::string> mode, projection, storage, reference;
  std::optional<double> operator_damping;            // [N s/m]
  std::optional<double> velocity_cutoff;             // [Hz]
  std::optional<double> c1, c2, coupling_stiffness;  // [N/m]
  std::optional<double> coupling_damping;            // [N s/m]
  std::optional<double> tool_mass;                   // [kg]
  friend bool operator==(const BoundWords&, const BoundWords&) = default;
};

struct BoundNumber {
  std::string_view name;
  std::optional<double> BoundWords::*wanted;
  std::variant<double SessionParameters::*, std::optional<double> SessionParameters::*> value;
};

inline constexpr std::array<BoundNumber, 7> kBoundNumbers = {{
    {"operator_damping", &BoundWords::operator_damping, &SessionParameters::operator_damping},
    {"velocity_cutoff", &BoundWords::velocity_cutoff, &SessionParameters::velocity_cutoff},
    {"c1", &BoundWords::c1, &SessionParameters::c1},
    {"c2", &BoundWords::c2, &SessionParameters::c2},
    {"coupling_stiffness", &BoundWords::coupling_stiffness, &SessionParameters::coupling_stiffness},
    {"coupling_damping", &BoundWords::coupling_damping, &SessionParameters::coupling_damping},
    {"tool_mass", &BoundWords::tool_mass, &SessionParameters::tool_mass},
}};

/// Empty: the default of the session's device.
inline std::optional<double> value_of(const BoundNumber& number,
                                      const SessionParameters& parameters) {
  return std::visit([&](auto field) { return std::optional<double>(parameters.*field); },
                    number.value);
}

/// Returns the changed parameters. Throws std::invalid_argument that lists the choices if a name
/// does not exist.
SessionParameters with_words(SessionParameters parameters, const BoundWords& words);

}  // namespace feltwire
