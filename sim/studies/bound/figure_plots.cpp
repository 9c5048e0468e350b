#include "sim/studies/bound/figure_plots.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "core/base/text.hpp"
#include "sim/report/plot.hpp"

namespace feltwire {
namespace {

constexpr const char* kPreamble =
    "set datafile separator ','\n"
    "set grid lc rgb '#dddddd'\n"
    "set key top right\n"
    "set style line 1 lc rgb '#1f4e79' lw 1.4\n"
    "set style line 2 lc rgb '#c0392b' lw 1.2\n"
    "set style line 3 lc rgb '#1f1f1f' lw 0.8 dt (5,6)\n"
    "set style line 4 lc rgb '#e8908a' lw 3.2\n";

/// Returns a gnuplot command that draws the commanded force as a dashed line over a broad line of
/// the rendered force. So both lines are visible if the forces are equal. `csv`: the command up to
/// the column; `commanded`: a gnuplot expression; `rendered`: a column.
std::string forces_drawn(const std::string& csv, const char* commanded, int rendered) {
  return "plot " + csv + std::to_string(rendered) + " with lines ls 4 title 'rendered', " + csv +
         commanded + " with lines ls 3 title 'commanded'\n";
}

std::string output(const std::string& file, int width, int height) {
  return "set terminal pngcairo size " + std::to_string(width) + "," + std::to_string(height) +
         " font 'Sans,11'\nset output '" + file + ".png'\n" + kPreamble;
}

/// The first part of the names of the runs in Figures 2 and 3. The damping of these runs is
/// 8 N s/m, the smallest of three values that agrees with the paper: the oscillation is small, and
/// the total energy of the port is positive.
constexpr const char* kWallFigures = "wall_b8_";

/// Returns the gnuplot script for a figure of the wall, as in the paper: position and force in x
/// and y over time, and the energies of Eq. (1) and (2). `depth` [um]: lower end of the axis of the
/// y position.
std::string wall_script(int figure, const std::string& run, int depth, const std::string& title) {
  const std::string csv = "'" + run + ".csv' skip 1 using 1:";
  std::string script = output("figure" + std::to_string(figure), 1100, 950);
  script += "set multiplot layout 3,2 title \"" + title +
            "\"\nset xlabel 'time [s]'\nset xrange [3:7]\nunset key\n"
            "set ylabel 'x position [mm]'\nset yrange [-35:35]\nplot " +
            csv + "($2*1e3) with lines ls 1\n";
  constexpr int kSpan = 150;  // [um] equal in both figures, so that oscillations can be compared
  append(script, "set ylabel 'y position [um]'\nset yrange [%d:%d]\nplot ", depth, depth + kSpan);
  script += csv + "($3*1e6) with lines ls 1\nset key top right\n";
  const auto forces = [&](const char* axis, const char* range, const char* commanded, int column) {
    append(script, "set ylabel '%s force on the hand [N]'\nset yrange %s\n", axis, range);
    script += forces_drawn(csv, commanded, column);
  };
  forces("x", "[-1.5:2.2]", "($5+$8)", 11);
  forces("y", "[0:20]", "($6+$9)", 12);
  script += "set key top left\n";
  const auto energy = [&](const char* label, const char* range, const char* equation,
                          const char* counted, const char* exchanged) {
    append(script,
           "set ylabel '%s energy flow-in [mJ]'\nset yrange %s\nplot 0 lc 'black' notitle, ", label,
           range);
    script += csv;
    append(script, "(1e3*(%s)) with lines ls 1 title 'F(n) dx(n): the law of %s', ", counted,
           equation);
    script += csv;
    append(script, "(1e3*(%s)) with lines ls 2 title 'F(n-1) dx(n): the port, and the paper'\n",
           exchanged);
  };
  energy("y", "[-15:25]", "Eq. (2)", "$15", "$18");
  energy("total", "[-50:400]", "Eq. (1)", "$14+$15+$16", "$17+$18+$19");
  return script + "unset multiplot\n";
}

/// Returns the gnuplot text of a panel with force arrows around the sphere, one arrow for each
/// 80 ms of the second turn. Dotted rays show the normals of the sphere.
std::string sphere_panel(const std::string& run, const std::string& title) {
  const std::string from = "'" + run + ".csv' skip 1 every 80::8000 using ";
  return "set title \"" + title +
         "\"\n"
         "set size ratio -1\nset xrange [-170:170]\nset yrange [-170:170]\n"
         "set xlabel 'x [mm]'\nset ylabel 'y [mm]'\n"
         "set object 1 circle at 0,0 size 90 fc rgb '#eef3f8' fs solid border lc rgb '#1f4e79' "
         "behind\n"
         "plot " +
         from +
         "($2*1e3):($3*1e3):($2*400):($3*400) with vectors nohead dt 3 lc rgb '#808080' "
         "title 'normal of the sphere', " +
         from +
         "($2*1e3):($3*1e3):($11*15):($12*15) with vectors head filled size 3,18 ls 2 "
         "title 'rendered force, 15 mm/N'\n";
}

std::string sphere_script(int figure, const std::string& run, const std::string& title) {
  return output("figure" + std::to_string(figure), 800, 800) + sphere_panel(run, title);
}

constexpr std::array<const char*, kFigureModes.size()> kModeTitles = {
    "none",          "total_energy (Eq. 1)", "per_axis (Eq. 2)", "per_axis_projected (Eq. 3)",
    "contact_frame", "shaped + account"};

std::string mode_run(const std::string& group, std::size_t mode) {
  return group + "_" + std::string(kFigureModes[mode]);
}

/// Escapes the underscores of a text. Between double quotes, gnuplot then shows the text unchanged.
std::string plain(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '_' ? "\\\\_" : std::string(1, c);
  return escaped;
}

std::string all_sphere_modes(const std::string& group) {
  std::string script =
      output("sphere_modes", 1500, 1050) +
      "set multiplot layout 2,3 title 'The sphere, 5 kN/m, b = 0.5 N s/m: force on the hand'\n";
  for (std::size_t i = 0; i < kModeTitles.size(); ++i)
    script += sphere_panel(mode_run(group, i), plain(kModeTitles[i]));
  return script + "unset multiplot\n";
}

/// Returns the gnuplot script for a figure with a column for each method: position and force at the
/// wall over half a second, and the force around the sphere. The titles contain the measured
/// numbers.
std::string summary(const std::vector<FigureRun>& runs) {
  const std::string wall = "wall_b2", sphere = "sphere_b0.5";
  const auto run_of = [&](const std::string& group, std::size_t mode) -> const FigureRun& {
    return *std::find_if(runs.begin(), runs.end(), [&](const FigureRun& run) {
      return run_name(run) == mode_run(group, mode);
    });
  };
  std::string script =
      output("summary", 2100, 1060) +
      "set multiplot layout 3,6 title 'What each law makes of the wall (40 kN/m with friction, b = "
      "2 N s/m) and of the sphere (5 kN/m, b = 0.5 N s/m)' font 'Sans,14'\n"
      "set xrange [4:4.5]\nset xtics 0.1\nset xlabel 'time [s]'\n"
      "set yrange [-1.4:0.6]\nset ylabel 'wall: y position [mm]'\nunset key\n";
  for (std::size_t i = 0; i < kModeTitles.size(); ++i) {
    append(script, "set title \"%s\\noscillates by %.0f um\"\nplot ",
           ("{/:Bold " + plain(kModeTitles[i]) + "}").c_str(),
           run_of(wall, i).metrics.highpass_rms.y() * 1e6);
    script += "'" + mode_run(wall, i) + ".csv' skip 1 using 1:($3*1e3) with lines ls 1\n";
  }
  script += "set yrange [0:60]\nset ylabel 'wall: y force on the hand [N]'\n";
  for (std::size_t i = 0; i < kModeTitles.size(); ++i) {
    append(script, "set title '%.0f %% of the commanded force'\n",
           100.0 * run_of(wall, i).metrics.force_ratio);
    const std::string csv = "'" + mode_run(wall, i) + ".csv' skip 1 using 1:";
    script += std::string(i == 0 ? "set key top right\n" : "unset key\n") +
              forces_drawn(csv, "($6+$9)", 12);
  }
  script += "set xtics 100\nset ytics 100\nunset key\n";
  for (std::size_t i = 0; i < kModeTitles.size(); ++i) {
    const ExperimentMetrics& m = run_of(sphere, i).metrics;
    std::string title;
    append(title, "%.0f %% of the force, %.0f degrees off", 100.0 * m.force_ratio,
           m.direction_error.mean * kDegrees);
    script += sphere_panel(mode_run(sphere, i), title);
  }
  return script + "unset multiplot\n";
}

}  // namespace

std::string run_group(const FigureRun& run) {
  std::array<char, 32> damping;
  std::snprintf(damping.data(), damping.size(), "_b%g", run.damping);
  return run.experiment + damping.data();
}

std::string run_name(const FigureRun& run) { return run_group(run) + "_" + std::string(run.mode); }

void draw_figures(const std::filesystem::path& directory, const std::vector<FigureRun>& runs) {
  const std::string wall = kWallFigures;
  plot(directory, "figure2",
       wall_script(2, wall + "total_energy", -150,
                   "Figure 2: stiff wall with friction (b = 8 N s/m), bounded by the total energy "
                   "only, Eq. (1): y trembles, and nothing acts"));
  plot(directory, "figure3",
       wall_script(3, wall + "per_axis", -450,
                   "Figure 3: the same wall, every axis passive by itself, Eq. (2)"));
  plot(directory, "figure5",
       sphere_script(5, "sphere_b0.5_per_axis", "Figure 5: per axis, before the projection"));
  plot(directory, "figure6",
       sphere_script(6, "sphere_b0.5_per_axis_projected",
                     "Figure 6: projected onto the commanded direction, Eq. (3)"));
  plot(directory, "sphere_modes", all_sphere_modes("sphere_b0.5"));
  plot(directory, "summary", summary(runs));
}

}  // namespace feltwire
