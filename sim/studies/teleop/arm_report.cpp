#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/studies/teleop/arm_bench.hpp"
#include "sim/studies/teleop/report_values.hpp"

namespace feltwire::teleop::with_arm {
namespace {

using Json = nlohmann::ordered_json;
using Maybe = std::optional<double>;

/// Returns the height [mm] of the lifted box, or the depth [mm] of the inserted peg.
Maybe carried(const ArmMeasured& m) {
  const Maybe& way = m.lifted ? m.lifted : m.inserted;
  return way ? Maybe(*way * kMilli) : std::nullopt;
}

Maybe peak_over_intended(const ArmMeasured& m) {
  return m.intended ? Maybe(m.peak / *m.intended) : std::nullopt;
}

}  // namespace

void write_arm(const std::filesystem::path& directory, const std::vector<ArmRow>& rows) {
  std::filesystem::create_directories(directory);
  Json list = Json::array();
  for (const ArmRow& row : rows) {
    const ArmMeasured& m = row.measured;
    list.push_back({{"task", row.made.task},
                    {"rtt_ms", row.made.round_trip * kMilli},
                    {"jitter_ms", row.made.jitter * kMilli},
                    {"loss", row.made.loss},
                    {"seed", row.made.seed},
                    {"intended_n", or_null(m.intended)},
                    {"peak_force_n", m.peak},
                    {"peak_over_intended", or_null(peak_over_intended(m))},
                    {"set_down_peak_n", or_null(m.set_down)},
                    {"robot_force_n", m.robot_force},
                    {"hand_force_n", m.hand_force},
                    {"force_error_n", m.force_error},
                    {"swing_um", m.swing * kMicro},
                    {"flicker_n", m.flicker},
                    {"fall_n", or_null(m.fall)},
                    {"displayed_over_series", or_null(m.displayed)},
                    {"offset_mm", m.offset * kMilli},
                    {"energy_made_j", m.energy_made},
                    {"lifted_mm", or_null(m.lifted, kMilli)},
                    {"inserted_mm", or_null(m.inserted, kMilli)},
                    {"stopped", m.stopped}});
  }
  write_text(directory / "arm.json", list.dump(0) + '\n');
}

std::string arm_table(const std::vector<ArmRow>& rows) {
  std::string text =
      "\nfeltwire's law with the simulated arm: median over the seeds, and the worst (of flicker "
      "and displayed: the worst); carried: the box up, the peg in\n"
      "  task    rtt ms jitter   loss seeds|intended N   peak N peak / intended   robot N "
      "hand / robot        swing um offset mm flicker N   fall N displayed carried mm  made J\n";
  for (auto first = rows.begin(); first != rows.end();) {
    const ArmCase& c = first->made;
    const auto last = std::find_if(first, rows.end(), [&](const ArmRow& r) {
      return r.made.task != c.task || r.made.round_trip != c.round_trip ||
             r.made.jitter != c.jitter || r.made.loss != c.loss;
    });
    // Returns the sorted values of a measured quantity, without the runs that do not have it.
    const auto over = [&](auto figure) {
      std::vector<double> values;
      for (auto row = first; row != last; ++row)
        if (const Maybe value = figure(row->measured)) values.push_back(*value);
      std::ranges::sort(values);
      return values;
    };
    const auto least = [](const std::vector<double>& v) {
      return v.empty() ? Maybe() : Maybe(v.front());
    };
    const auto middle = [](const std::vector<double>& v) {
      return v.empty() ? Maybe() : Maybe(v[(v.size() - 1) / 2]);
    };
    const auto most = [](const std::vector<double>& v) {
      return v.empty() ? Maybe() : Maybe(v.back());
    };
    const auto share = [](const ArmMeasured& m) { return Maybe(m.hand_force / m.robot_force); };
    const auto off = [&](const ArmMeasured& m) { return Maybe(std::abs(*share(m) - 1.0)); };
    const std::vector<double> ratios = over(peak_over_intended);
    append(text, "  %-6s %7.0f %6.0f %6.2f %5d|", c.task.c_str(), c.round_trip * kMilli,
           c.jitter * kMilli, c.loss, static_cast<int>(last - first));
    text += cell(10, 2, middle(over([](const ArmMeasured& m) { return m.intended; })));
    text += cell(9, 2, middle(over([](const ArmMeasured& m) { return Maybe(m.peak); })));
    text += cell(7, 2, middle(ratios)) + ',' + cell(7, 2, most(ratios));
    text += cell(10, 2, middle(over([](const ArmMeasured& m) { return Maybe(m.robot_force); })));
    text += cell(7, 2, middle(over(share))) + ", off" + cell(6, 2, most(over(off)));
    text += cell(9, 1, middle(over([](const ArmMeasured& m) { return Maybe(m.swing * kMicro); })));
    text +=
        cell(10, 1, middle(over([](const ArmMeasured& m) { return Maybe(m.offset * kMilli); })));
    text += cell(10, 2, most(over([](const ArmMeasured& m) { return Maybe(m.flicker); })));
    text += cell(9, 2, most(over([](const ArmMeasured& m) { return m.fall; })));
    text += cell(10, 2, least(over([](const ArmMeasured& m) { return m.displayed; })));
    text += cell(10, 1, middle(over([](const ArmMeasured& m) { return carried(m); })));
    const bool stopped =
        std::any_of(first, last, [](const ArmRow& r) { return r.measured.stopped; });
    append(text, " %8.2g%s\n",
           *most(over([](const ArmMeasured& m) { return Maybe(m.energy_made); })),
           stopped ? "  STOPPED" : "");
    first = last;
  }
  return text;
}

}  // namespace feltwire::teleop::with_arm
