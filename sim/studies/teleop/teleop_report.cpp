#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/teleop/report_values.hpp"
#include "sim/studies/teleop/teleop.hpp"
#include "sim/teleoperation_laws/laws.hpp"

namespace feltwire::teleop {
namespace {

using Json = nlohmann::ordered_json;

Json json(const TeleopRow& row) {
  const TeleopCase& c = row.made;
  const Measured& m = row.measured;
  return {{"law", c.law},
          {"task", c.task},
          {"rtt_ms", c.round_trip * kMilli},
          {"jitter_ms", c.jitter * kMilli},
          {"loss", c.loss},
          {"displayed_over_series", or_null(m.displayed)},
          {"oscillation_um", or_null(m.oscillation, kMicro)},
          {"drag_n", or_null(m.drag)},
          {"tracking_mm", or_null(m.tracking, kMilli)},
          {"force_error_n", or_null(m.force_error)},
          {"force_error_share", or_null(m.force_share)},
          {"drift_mm", or_null(m.drift, kMilli)},
          {"inserted_mm", or_null(m.inserted, kMilli)},
          {"energy_made_j", m.energy_made},
          {"peak_force_n", m.peak_force},
          {"phantom_share", or_null(m.phantom)},
          {"release_ms", or_null(m.release, kMilli)}};
}

std::string number(const std::optional<double>& measured, double scale = 1.0) {
  std::string text;
  if (measured)
    append(text, "%.5g", *measured * scale);
  else
    text = "nan";
  return text;
}

std::string csv(const std::vector<TeleopRow>& rows) {
  std::string text =
      "law,task,rtt_ms,jitter_ms,loss,displayed_over_series,oscillation_um,drag_n,tracking_mm,"
      "force_error_n,force_error_share,drift_mm,inserted_mm,energy_made_j,peak_force_n,"
      "phantom_share,release_ms\n";
  for (const TeleopRow& r : rows) {
    const Measured& m = r.measured;
    append(text, "%s,%s,%g,%g,%g,", r.made.law.c_str(), r.made.task.c_str(),
           r.made.round_trip * kMilli, r.made.jitter * kMilli, r.made.loss);
    for (const std::string& field :
         {number(m.displayed), number(m.oscillation, kMicro), number(m.drag),
          number(m.tracking, kMilli), number(m.force_error), number(m.force_share),
          number(m.drift, kMilli), number(m.inserted, kMilli), number(m.energy_made)})
      text += field + ',';
    text += number(m.peak_force) + ',' + number(m.phantom) + ',' + number(m.release, kMilli) + '\n';
  }
  return text;
}

// Okabe and Ito chose most of these colours for colour-blind readers. The greys are added.
constexpr std::array kColors = {"#999999", "#000000", "#cc79a7", "#56b4e9", "#0072b2", "#f0e442",
                                "#e69f00", "#bbbbbb", "#666666", "#d55e00", "#009e73", "#44aa99"};

/// Draws panels with a curve for each law over the round-trip time, without jitter and loss.
void draw(const std::filesystem::path& directory, const std::vector<TeleopRow>& rows) {
  const auto all = law_names();
  const auto panel = [&](const char* title, const char* task, int column, double scale,
                         const char* label) {
    std::string text;
    append(text, "set title '%s'\nset ylabel '%s'\nplot ", title, label);
    const char* separator = "";
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::string law(all[i]);
      if (std::ranges::none_of(rows, [&](const TeleopRow& r) {
            return r.made.law == law && r.made.task == task && r.made.jitter == 0.0 &&
                   r.made.loss == 0.0;
          }))
        continue;
      append(text, "%s'teleop.csv' skip 1 using ((strcol(1) eq '%s' && ", separator, law.c_str());
      separator = ", ";
      append(text, "strcol(2) eq '%s' && $4 == 0 && $5 == 0) ? $3 : NaN):(%g * $%d) ", task, scale,
             column);
      append(text, "with linespoints lw 1.6 pt 7 ps 0.8 lc rgb '%s' title '%s'", kColors.at(i),
             law.c_str());
    }
    if (*separator == '\0') return std::string();  // no data to plot
    return text + "\nunset key\n";
  };
  std::string script =
      "set terminal pngcairo size 1900,820 font 'Sans,11'\nset output 'teleop.png'\n"
      "set datafile separator ','\nset datafile missing NaN\nset grid lt 1 lc rgb '#dddddd'\nset "
      "xrange [0:300]\n"
      "set key noenhanced top right maxrows 6\nset xlabel 'round trip [ms]'\n"
      "set multiplot layout 2,4 title 'Teleoperation laws, no jitter, no loss'\n";
  script += "set yrange [0:2]\n";
  constexpr int kDisplayed = 6, kDrag = 8, kError = 10, kMade = 14;
  script += panel("first press", "press_first", kDisplayed, 1.0, "displayed / series stiffness");
  script += "set yrange [0:1.5]\n";
  script += panel("second press", "press_second", kDisplayed, 1.0, "displayed / series stiffness");
  script += "set yrange [0:*]\n";
  script += panel("free motion", "free", kDrag, 1.0, "drag [N]");
  script += panel("taps", "taps", kError, 1.0, "force error [N]");
  script += panel("moving wall", "moving_wall", kError, 1.0, "force error [N]");
  script += panel("around a ball", "sphere", kError, 1.0, "force error [N]");
  script += panel("peg", "peg", kError, 1.0, "force error [N]");
  script += "set logscale y\nset yrange [1e-6:100]\n";
  script += panel("moving wall", "moving_wall", kMade, 1.0, "energy made [J]");
  script += "unset multiplot\n";
  plot(directory, "teleop", script);
}

}  // namespace

void write_teleop(const std::filesystem::path& directory, const std::vector<TeleopRow>& rows) {
  std::filesystem::create_directories(directory);
  Json list = Json::array();
  for (const TeleopRow& row : rows) list.push_back(json(row));
  write_text(directory / "teleop.json", list.dump(0) + '\n');
  write_text(directory / "teleop.csv", csv(rows));
  draw(directory, rows);
}

std::string teleop_table(const std::vector<TeleopRow>& rows) {
  constexpr double kTrip = 0.1;
  std::string text;
  const auto block = [&](const char* title, double jitter, double loss) {
    const auto find = [&](std::string_view law, std::string_view task) -> const Measured* {
      const auto row = std::ranges::find_if(rows, [&](const TeleopRow& r) {
        return r.made.law == law && r.made.task == task && r.made.round_trip == kTrip &&
               r.made.jitter == jitter && r.made.loss == loss;
      });
      return row != rows.end() ? &row->measured : nullptr;
    };
    append(text, "\n%s\n", title);
    append(text, "  %-22s|   first   second swing um   drag N track mm   taps N moving N", "law");
    text += "  free ms vanish N   lift N blackout drift mm sphere N    peg N    in mm   made J\n";
    for (const std::string_view law : law_names()) {
      append(text, "  %-22s|", std::string(law).c_str());
      const auto add = [&](std::string_view task, auto field, double scale, int digits) {
        const Measured* m = find(law, task);
        text += cell(9, digits, m != nullptr ? (*m).*field : std::nullopt, scale);
      };
      constexpr int kFine = 3, kCoarse = 1, kTwo = 2;
      add("press_first", &Measured::displayed, 1.0, kFine);
      add("press_second", &Measured::displayed, 1.0, kFine);
      add("press_second", &Measured::oscillation, kMicro, kCoarse);
      add("free", &Measured::drag, 1.0, kFine);
      add("free", &Measured::tracking, kMilli, kTwo);
      add("taps", &Measured::force_error, 1.0, kFine);
      add("moving_wall", &Measured::force_error, 1.0, kFine);
      add("leaving_wall", &Measured::release, kMilli, kCoarse);
      add("vanishing_wall", &Measured::force_error, 1.0, kFine);
      add("lift", &Measured::force_error, 1.0, kFine);
      add("blackout", &Measured::displayed, 1.0, kFine);
      add("drift", &Measured::drift, kMilli, kFine);
      add("sphere", &Measured::force_error, 1.0, kFine);
      add("peg", &Measured::force_error, 1.0, kFine);
      add("peg", &Measured::inserted, kMilli, kCoarse);
      double made = 0.0;
      for (const TeleopRow& r : rows)
        if (r.made.law == law && r.made.jitter == jitter && r.made.loss == loss)
          made = std::max(made, r.measured.energy_made);
      append(text, " %8.2g\n", made);
    }
  };
  text += "Round trip 100 ms; the energy is the most of all tasks and round trips.\n";
  block("Perfect link", 0.0, 0.0);
  block("5 ms jitter, 5 % loss", 5e-3, 0.05);
  return text;
}

}  // namespace feltwire::teleop
