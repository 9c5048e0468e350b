#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/measure/experiment_metrics.hpp"
#include "sim/report/plot.hpp"
#include "sim/studies/network/where_to_bound.hpp"

namespace feltwire {
namespace {

template <class Get>
auto distinct(const std::vector<WhereToBoundCell>& cells, const Get& get) {
  std::vector<std::decay_t<decltype(get(cells.front()))>> values;
  for (const WhereToBoundCell& cell : cells)
    if (std::find(values.begin(), values.end(), get(cell)) == values.end())
      values.push_back(get(cell));
  return values;
}
std::vector<std::string_view> tasks(const std::vector<WhereToBoundCell>& cells) {
  return distinct(cells, [](const WhereToBoundCell& cell) { return cell.task; });
}
std::vector<double> round_trips(const std::vector<WhereToBoundCell>& cells) {
  return distinct(cells, [](const WhereToBoundCell& cell) { return cell.round_trip; });
}

std::string csv(const std::vector<WhereToBoundCell>& cells) {
  std::string text =
      "task,bound,round_trip_ms,jitter_ms,loss_percent,burst,oscillation_um,sway_um,"
      "displayed_n_per_m,direction_mean_deg,direction_p99_deg,force_ratio,force_error,margin_j,"
      "true_margin_j,device_margin_j,violations,answered\n";
  for (const WhereToBoundCell& c : cells) {
    append(text, "%s,%s,%g,%g,%g,%g,%.4g,%.4g,%.5g,%.4g,%.4g,%.4g,%.4g,",
           std::string(c.task).c_str(), std::string(c.bound).c_str(), c.round_trip * kMilli,
           c.jitter * kMilli, c.loss.loss * kPercent, c.loss.burst, c.oscillation * kMicro,
           c.sway * kMicro, c.displayed, c.direction_mean * kDegrees, c.direction_p99 * kDegrees,
           c.force_ratio, c.force_error);
    append(text, "%.4g,%.4g,%.4g,%llu,%.4g\n", c.margin, c.true_margin, c.device_margin,
           static_cast<unsigned long long>(c.violations), c.answered);
  }
  return text;
}

nlohmann::ordered_json json(const std::vector<WhereToBoundCell>& cells) {
  auto list = nlohmann::ordered_json::array();
  for (const WhereToBoundCell& c : cells)
    list.push_back({{"task", c.task},
                    {"bound", c.bound},
                    {"round_trip_ms", c.round_trip * kMilli},
                    {"jitter_ms", c.jitter * kMilli},
                    {"loss_percent", c.loss.loss * kPercent},
                    {"burst", c.loss.burst},
                    {"oscillation_um", c.oscillation * kMicro},
                    {"sway_um", c.sway * kMicro},
                    {"displayed_n_per_m", c.displayed},
                    {"direction_mean_deg", c.direction_mean * kDegrees},
                    {"direction_p99_deg", c.direction_p99 * kDegrees},
                    {"force_ratio", c.force_ratio},
                    {"force_error", c.force_error},
                    {"margin_j", c.margin},
                    {"true_margin_j", c.true_margin},
                    {"device_margin_j", c.device_margin},
                    {"violations", c.violations},
                    {"answered", c.answered}});
  return list;
}

struct Panel {
  const char* label;
  const char* column;
  const char* range;
};
constexpr Panel kPanels[] = {{"oscillation [um RMS]", "($7 > 0.1 ? $7 : 0.1)", "[0.08:1e4]"},
                             {"displayed stiffness [N/m]", "($9 > 10 ? $9 : 10)", "[8:2e4]"},
                             {"energy made [J]", "(-$14 > 1e-5 ? -$14 : 1e-5)", "[8e-6:20]"}};
// Okabe and Ito chose these colours for colour-blind readers. The point types differ too.
constexpr const char* kColors[] = {"#999999", "#d55e00", "#0072b2", "#009e73"};
constexpr const char* kPoints[] = {"pt 2 ps 1.2", "pt 4 ps 1.2", "pt 7 ps 1", "pt 6 ps 1.8"};

/// Draws a row of panels for each measured quantity, with a column for each task and a curve for
/// each bound (none, server, client, both). The curves are for a link without jitter and loss. The
/// dots are for all jitters and losses.
void draw(const std::filesystem::path& directory, const std::vector<WhereToBoundCell>& cells) {
  const auto columns = tasks(cells);
  std::string script =
      "set terminal pngcairo size 1750,1000 font 'Sans,11'\nset output 'sides.png'\n"
      "set datafile separator ','\nset datafile missing NaN\nset tics nomirror\n"
      "set grid lt 1 lc rgb '#dddddd'\nset logscale xy\nset xrange [0.7:300]\n"
      "set xlabel 'round trip [ms]'\nset key center right samplen 2\nset format y '10^{%T}'\n";
  script += "set xtics font ',9' (";
  for (const double round_trip : round_trips(cells))
    append(script, "%s'%g' %g", round_trip == cells.front().round_trip ? "" : ", ",
           round_trip * kMilli, std::max(round_trip * kMilli, 1.0));
  append(script,
         ")\nset multiplot layout %zu,%zu title 'Who bounds (contact\\_frame, b = 0.5 N s/m, 1 "
         "kHz): over a line without jitter and loss (curves), and over all of them (dots)'\n",
         std::size(kPanels), columns.size());
  for (const Panel& panel : kPanels)
    for (const std::string_view task : columns) {
      append(script, "set title '%s'\nset ylabel '%s'\nset yrange %s\n", std::string(task).c_str(),
             panel.label, panel.range);
      // Only the last panel has room for the legend.
      const bool last = panel.column == std::rbegin(kPanels)->column && task == columns.back();
      script += last ? "set key\nplot " : "unset key\nplot ";
      for (std::size_t i = 0; i < std::size(kSidesBounds); ++i) {
        const std::string bound(kSidesBounds[i]);
        std::string rows;
        append(rows, "strcol(1) eq '%s' && strcol(2) eq '%s'", std::string(task).c_str(),
               bound.c_str());
        // Shift the points of different bounds horizontally, so that they do not overlap.
        append(script, "'sides.csv' skip 1 using (($3 > 0 ? $3 : 1)*%g):(%s ? %s : NaN) ",
               0.94 + 0.04 * static_cast<double>(i), rows.c_str(), panel.column);
        append(script, "with points pt 7 ps 0.25 lc rgb '%s' notitle, ", kColors[i]);
        append(script, "'' skip 1 using ($3 > 0 ? $3 : 1):(%s && $4 == 0 && ", rows.c_str());
        append(script, "$5 == 0 ? %s : NaN) with linespoints %s lw 1.6 lc rgb '%s' title '%s', ",
               panel.column, kPoints[i], kColors[i], bound.c_str());
      }
      script += "NaN notitle\n";
    }
  plot(directory, "sides", script + "unset multiplot\n");
}

/// Returns the head of a table with four groups of columns. Each group has a column for each of the
/// four bounds.
std::string heads(std::string_view task, const char* over,
                  const std::array<const char*, 4>& names) {
  std::string text = "\n" + std::string(task) + ", " + over + "\nround   ";
  for (const char* head : names) append(text, "%29s", head);
  text += "\ntrip, ms";
  for (std::size_t i = 0; i < names.size(); ++i) text += "   none server client   both";
  return text + '\n';
}

void clean_table(std::string& text, const std::vector<WhereToBoundCell>& cells,
                 std::string_view task) {
  text += heads(task, "no jitter, no loss",
                {"oscillation [um RMS]", "displayed [N/m]", "direction [deg]", "energy made [J]"});
  for (const double round_trip : round_trips(cells)) {
    std::string columns[4];
    for (const std::string_view bound : kSidesBounds)
      for (const WhereToBoundCell& c : cells) {
        if (c.task != task || c.bound != bound || c.round_trip != round_trip || !clean(c)) continue;
        append(columns[0], " %6.1f", c.oscillation * kMicro);
        append(columns[1], " %6.0f", c.displayed);
        append(columns[2], " %6.2f", c.direction_mean * kDegrees);
        append(columns[3], " %6.3f", c.violations > 0 ? -c.margin : 0.0);
      }
    append(text, "%8g", round_trip * kMilli);
    for (const std::string& column : columns) text += ' ' + column;
    text += '\n';
  }
}

/// Results for a bound and a round-trip time, over all jitters and losses.
struct Overall {
  double oscillation = 0.0, displayed = 0.0, error = 0.0;  // largest of the runs; sums
  int broken = 0, count = 0;
};

void overall_table(std::string& text, const std::vector<WhereToBoundCell>& cells,
                   std::string_view task) {
  text += heads(task, "over all jitters and losses",
                {"worst oscillation [um RMS]", "mean displayed [N/m]", "mean force error [%]",
                 "runs that made energy"});
  for (const double round_trip : round_trips(cells)) {
    std::string columns[4];
    for (const std::string_view bound : kSidesBounds) {
      Overall o;
      for (const WhereToBoundCell& c : cells) {
        if (c.task != task || c.bound != bound || c.round_trip != round_trip) continue;
        o.oscillation = std::max(o.oscillation, c.oscillation);
        o.displayed += c.displayed;
        o.error += c.force_error;
        o.broken += c.violations > 0 ? 1 : 0;
        ++o.count;
      }
      append(columns[0], " %6.1f", o.oscillation * kMicro);
      append(columns[1], " %6.0f", o.displayed / std::max(o.count, 1));
      append(columns[2], " %6.1f", kPercent * o.error / std::max(o.count, 1));
      append(columns[3], " %3d/%-2d", o.broken, o.count);
    }
    append(text, "%8g", round_trip * kMilli);
    for (const std::string& column : columns) text += ' ' + column;
    text += '\n';
  }
}

/// Adds a table that compares two bounds (at server and client) with the client's bound alone, over
/// all round-trip times, jitters and losses.
void difference_table(std::string& text, const std::vector<WhereToBoundCell>& cells) {
  constexpr double kNotable = 0.01;
  text +=
      "\nWhat the server's bound before the client's changes: runs in which both differ from the "
      "client alone by over 1 %\n                of   displayed         mean [N/m]      "
      "oscillation\n                runs  less  more   client   both    less  more\n";
  for (const std::string_view task : tasks(cells)) {
    std::vector<const WhereToBoundCell*> client, both;
    for (const WhereToBoundCell& c : cells) {
      if (c.task != task) continue;
      if (c.bound == "client") client.push_back(&c);
      if (c.bound == "both") both.push_back(&c);
    }
    struct Count {
      int less = 0, more = 0;
      void take(double one, double other, double notable) {
        less += other < one - notable ? 1 : 0;
        more += other > one + notable ? 1 : 0;
      }
    } displayed, oscillation;
    double client_sum = 0.0, both_sum = 0.0;
    for (std::size_t i = 0; i < client.size() && i < both.size(); ++i) {
      const WhereToBoundCell &a = *client[i], &b = *both[i];
      displayed.take(a.displayed, b.displayed, kNotable * a.displayed);
      oscillation.take(a.oscillation, b.oscillation, std::max(1e-6, kNotable * a.oscillation));
      client_sum += a.displayed;
      both_sum += b.displayed;
    }
    const double count = std::max(1.0, static_cast<double>(client.size()));
    append(text, "%-14s %5zu %5d %5d %8.0f %6.0f %7d %5d\n", std::string(task).c_str(),
           client.size(), displayed.less, displayed.more, client_sum / count, both_sum / count,
           oscillation.less, oscillation.more);
  }
}

}  // namespace

std::string where_to_bound_table(const std::vector<WhereToBoundCell>& cells) {
  std::string text =
      "Who bounds: nobody, the server, the client, both. contact_frame, b = 0.5 N s/m, 1 kHz.\n";
  for (const std::string_view task : tasks(cells)) clean_table(text, cells, task);
  for (const std::string_view task : tasks(cells)) overall_table(text, cells, task);
  difference_table(text, cells);
  text += "\nRuns in which the hand was given more energy than the device burned\n";
  for (const std::string_view bound : kSidesBounds) {
    std::size_t runs = 0, broken = 0;
    double least = 0.0;
    for (const WhereToBoundCell& c : cells) {
      if (c.bound != bound) continue;
      ++runs;
      broken += c.violations > 0 ? 1 : 0;
      least = std::min(least, c.margin);
    }
    append(text, "%-7s %5zu of %zu, at most %.3g J\n", std::string(bound).c_str(), broken, runs,
           broken > 0 ? -least : 0.0);
  }
  return text;
}

void write_where_to_bound(const std::filesystem::path& directory,
                          const std::vector<WhereToBoundCell>& cells) {
  std::filesystem::create_directories(directory);
  write_text(directory / "sides.csv", csv(cells));
  write_text(directory / "sides.json", json(cells).dump(1) + '\n');
  draw(directory, cells);
}

}  // namespace feltwire
