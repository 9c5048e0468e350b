#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/studies/bound/torque.hpp"

namespace feltwire {
namespace {

const char* ports_name(const TorqueCase& c) {
  if (!c.account) return "none";
  return c.ports == Ports::one ? "one" : "two";
}

nlohmann::ordered_json json(const TorqueRow& row) {
  const TorqueCase& c = row.made;
  return {{"task", c.task},
          {"law", c.law},
          {"accounts", ports_name(c)},
          {"b_r", c.damping},
          {"stiffness", c.stiffness},
          {"delay_ms", c.delay * kMilli},
          {"hand", c.hand.name},
          {"oscillation_mrad", row.oscillation * kMilli},
          {"force_share", row.force_share},
          {"torque_share", row.torque_share},
          {"direction_error_deg", row.direction_error * kDegrees},
          {"energy_made_j", row.energy.measured},
          {"energy_made_true_j", row.energy.real},
          {"energy_made_force_j", row.energy.force},
          {"energy_made_torque_j", row.energy.torque},
          {"excess_count", row.excess}};
}

/// Returns a CSV text with a column for each name in json().
std::string csv(const std::vector<TorqueRow>& rows) {
  std::string text;
  for (const TorqueRow& row : rows) {
    const nlohmann::ordered_json values = json(row);
    if (text.empty()) {
      for (const auto& [key, value] : values.items()) text += key + ",";
      text.back() = '\n';
    }
    for (const auto& value : values) {
      if (value.is_string())
        text += value.get<std::string>() + ",";
      else
        append(text, "%.5g,", value.get<double>());
    }
    text.back() = '\n';
  }
  return text;
}

struct OverCases {
  double swing = 0.0, most_swing = 0.0;               // [rad] median and worst oscillation
  double torque = 0.0, force = 0.0, direction = 0.0;  // medians: ratios to the command, error [rad]
  // [J] largest energy made in a case: at the encoders, in all and by torque; at the true motor
  double energy = 0.0, by_torque = 0.0, at_motor = 0.0;
};

OverCases over(const std::vector<TorqueRow>& rows,
               const std::function<bool(const TorqueCase&)>& picks) {
  OverCases sum;
  std::vector<double> torque, force, direction, swing;
  for (const TorqueRow& row : rows) {
    if (!picks(row.made)) continue;
    swing.push_back(row.oscillation);
    sum.most_swing = std::max(sum.most_swing, row.oscillation);
    torque.push_back(row.torque_share);
    force.push_back(row.force_share);
    direction.push_back(row.direction_error);
    sum.energy = std::max(sum.energy, row.energy.measured);
    sum.by_torque = std::max(sum.by_torque, row.energy.torque);
    sum.at_motor = std::max(sum.at_motor, row.energy.real);
  }
  sum.swing = median(swing);
  sum.torque = median(torque);
  sum.force = median(force);
  sum.direction = median(direction);
  return sum;
}

/// Returns the name of the local model that the client has.
const char* model_name(const TorqueSession& s) {
  if (!s.local_model) return "no";
  return s.whole ? "whole" : "planes";
}

bool is_joint(const TorqueCase& c) { return c.stiffness > 0.0; }

/// Returns a case for each law, in the order of the rows.
std::vector<TorqueCase> laws_of(const std::vector<TorqueRow>& rows, bool joints, double delay) {
  std::vector<TorqueCase> laws;
  for (const TorqueRow& row : rows) {
    if (is_joint(row.made) != joints || row.made.delay != delay) continue;
    const auto same = [&](const TorqueCase& c) {
      return c.law == row.made.law && c.account == row.made.account && c.ports == row.made.ports;
    };
    if (std::ranges::none_of(laws, same)) laws.push_back(row.made);
  }
  return laws;
}

}  // namespace

std::string torque_table(const std::vector<TorqueRow>& rows) {
  std::string text;
  for (const bool joints : {true, false})
    for (const double delay : {0.0, 0.02}) {
      const auto laws = laws_of(rows, joints, delay);
      if (laws.empty()) continue;
      const bool plant = laws.front().plant != nullptr;
      append(text,
             "\n%s, round trip %.0f ms\n"
             "law                 accounts  oscillation [mrad]  torque  force   direction  energy "
             "made [mJ]\n"
             "                              median    worst     shown   shown   off [deg]  port    "
             " by "
             "torque%s\n",
             joints ? "Stops of a joint" : "Bodies in the hand", delay * kMilli,
             plant ? "  at the motor" : "");
      for (const TorqueCase& law : laws) {
        const OverCases o = over(rows, [&](const TorqueCase& c) {
          return is_joint(c) == joints && c.delay == delay && c.law == law.law &&
                 c.account == law.account && c.ports == law.ports;
        });
        append(text, "%-18s  %-8s  %7.2f  %9.2f  %6.2f  %6.2f  %9.1f  %8.3f  %8.3f",
               law.law.c_str(), ports_name(law), o.swing * kMilli, o.most_swing * kMilli, o.torque,
               joints ? 0.0 : o.force, o.direction * kDegrees, o.energy * kMilli,
               o.by_torque * kMilli);
        if (plant) append(text, "  %12.3g", o.at_motor * kMilli);
        text += '\n';
      }
    }
  return text;
}

std::string torque_sessions_table(const std::vector<TorqueSession>& sessions) {
  std::string text =
      "\nSessions of a body, eight hands each: medians; energy and violations the most\n"
      "task         mode           link                                   model   torque error  "
      "usual   oscillation  largest jump  energy made  true     viol.\n"
      "                                                                           [%]           "
      "[mN m]  [mrad]       [mN m]        [mJ]         [mJ]\n";
  for (std::size_t i = 0; i + kEightHands.size() <= sessions.size(); i += kEightHands.size()) {
    const TorqueSession& first = sessions[i];
    std::vector<double> error, usual, swing;
    double energy = 0.0, real = 0.0, jump = 0.0;
    std::uint64_t violations = 0;
    for (std::size_t n = i; n < i + kEightHands.size(); ++n) {
      const TorqueSession& s = sessions[n];
      error.push_back(s.ideal_rms > 0.0 ? s.torque_error / s.ideal_rms : 0.0);
      usual.push_back(s.usual_error);
      swing.push_back(s.oscillation);
      jump = std::max(jump, s.largest_jump);
      energy = std::max(energy, s.energy_made);
      real = std::max(real, s.energy_made_true);
      violations = std::max(violations, s.violations);
    }
    append(text, "%-11s  %-13s  %-37s  %-6s  %12.1f  %6.3f  %11.3f  %12.2f  %11.4f  %7.4f  %llu\n",
           first.task.c_str(), first.mode.c_str(), first.link.c_str(), model_name(first),
           100.0 * median(error), median(usual) * kMilli, median(swing) * kMilli, jump * kMilli,
           energy * kMilli, real * kMilli, static_cast<unsigned long long>(violations));
  }
  return text;
}

void write_torque(const std::filesystem::path& directory, const std::vector<TorqueRow>& rows,
                  const std::vector<TorqueSession>& sessions) {
  std::filesystem::create_directories(directory);
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const TorqueRow& row : rows) all.push_back(json(row));
  write_text(directory / "torque.json", all.dump(1) + '\n');
  write_text(directory / "torque.csv", csv(rows));
  std::string text =
      "task,mode,link,model,hand,energy_made_j,energy_made_true_j,violations,torque_rms_nm,"
      "ideal_rms_nm,"
      "torque_error_nm,usual_error_nm,oscillation_mrad,largest_jump_nm\n";
  for (const TorqueSession& s : sessions)
    append(text, "%s,%s,\"%s\",%s,%s,%.5g,%.5g,%llu,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g\n",
           s.task.c_str(), s.mode.c_str(), s.link.c_str(), model_name(s),
           std::string(s.hand.name).c_str(), s.energy_made, s.energy_made_true,
           static_cast<unsigned long long>(s.violations), s.torque_rms, s.ideal_rms, s.torque_error,
           s.usual_error, s.oscillation * kMilli, s.largest_jump);
  write_text(directory / "torque_sessions.csv", text);
}

}  // namespace feltwire
