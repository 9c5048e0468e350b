#include "server/scene/parameter_changes.hpp"

#include <spdlog/fmt/fmt.h>

namespace feltwire {
namespace {

template <class Value>
std::string word(const Value& value) {
  if constexpr (std::is_enum_v<Value>)
    return std::string(name(value));
  else
    return fmt::format("{}", value);
}
std::string word(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : "usual";
}

}  // namespace

std::string changes(const SessionParameters& before, const SessionParameters& after) {
  using P = SessionParameters;
  std::string text;
  const auto compare = [&](const char* field, auto P::*value) {
    if (before.*value == after.*value) return;
    text += fmt::format("{}{} {} -> {}", text.empty() ? "" : ", ", field, word(before.*value),
                        word(after.*value));
  };
  compare("mode", &P::mode);
  compare("projection", &P::projection);
  compare("storage", &P::storage);
  compare("side", &P::side);
  compare("servo_period", &P::servo_period);
  compare("redundancy", &P::redundancy);
  compare("operator_damping", &P::operator_damping);
  compare("velocity_cutoff", &P::velocity_cutoff);
  compare("hold_time", &P::hold_time);
  compare("c1", &P::c1);
  compare("c2", &P::c2);
  compare("reference", &P::reference);
  compare("coupling_stiffness", &P::coupling_stiffness);
  compare("coupling_damping", &P::coupling_damping);
  compare("tool_mass", &P::tool_mass);
  compare("packet_interval", &P::packet_interval);
  compare("batch", &P::batch);
  compare("position_deadband", &P::position_deadband);
  compare("force_deadband", &P::force_deadband);
  compare("predictor", &P::predictor);
  compare("keep_alive", &P::keep_alive);
  compare("local_model", &P::local_model);
  return text.empty() ? "nothing changed" : text;
}

}  // namespace feltwire
