#include "sim/studies/bound/figure_plots.hpp"

#include <array>
#include <cstdio>

#include "sim/report/plot.hpp"

namespace feltwire {
namespace {

constexpr const char* kPreamble =
    "set datafile separator ','\n"
    "set grid lc rgb '#dddddd'\n"
    "set key top right opaque\n"
    "set style line 1 lc rgb '#1f4e79' lw 1.4\n"
    "set style line 2 lc rgb '#c0392b' lw 1.2\n"
    "set style line 3 lc rgb '#7f8c8d' lw 1.0\n";

std::string output(const std::string& file, int width, int height) {
  return "set terminal pngcairo size " + std::to_string(width) + "," + std::to_string(height) +
         " font 'Sans,11'\nset output '" + file + ".png'\n" + kPreamble;
}

/// The wall in the paper's form: position and force of both axes over time, and the energy that Eq.
/// (1) and (2) watch.
std::string wall_script(int figure, const std::string& run, const std::string& title) {
  const std::string csv = "'" + run + ".csv' skip 1 using 1:";
  return output("figure" + std::to_string(figure), 1100, 950) +
         "set multiplot layout 3,2 title \"" + title +
         "\"\n"
         "set xlabel 'time [s]'\nset xrange [3:7]\nunset key\n"
         "set ylabel 'x position [mm]'\nplot " +
         csv +
         "($2*1e3) with lines ls 1\n"
         "set ylabel 'y position [mm]'\nset yrange [-4:1]\nplot " +
         csv +
         "($3*1e3) with lines ls 1\nset yrange [*:*]\n"
         "set key top right opaque\n"
         "set ylabel 'x force on the hand [N]'\nplot " +
         csv + "($5+$8) with lines ls 3 title 'commanded', " + csv +
         "11 with lines ls 2 title 'rendered'\n"
         "set ylabel 'y force on the hand [N]'\nplot " +
         csv + "($6+$9) with lines ls 3 title 'commanded', " + csv +
         "12 with lines ls 2 title 'rendered'\n"
         "set key top left\n"
         "set ylabel 'y energy flow-in [J]'\nplot " +
         csv + "15 with lines ls 1 title 'as Eq. (2) counts', " + csv +
         "18 with lines ls 2 title 'as the port exchanged'\n"
         "set ylabel 'total energy flow-in [J]'\nplot " +
         csv + "($14+$15+$16) with lines ls 1 title 'as Eq. (1) counts', " + csv +
         "($17+$18+$19) with lines ls 2 title 'as the port exchanged'\n"
         "unset multiplot\n";
}

/// Force arrows round the sphere, one every 80 ms of the second turn; the dashed rays are the true
/// normals.
std::string sphere_panel(const std::string& run, const std::string& title) {
  const std::string from = "'" + run + ".csv' skip 1 every 80::8000 using ";
  return "set title \"" + title +
         "\"\n"
         "set size ratio -1\nset xrange [-150:150]\nset yrange [-150:150]\n"
         "set xlabel 'x [mm]'\nset ylabel 'y [mm]'\n"
         "set object 1 circle at 0,0 size 90 fc rgb '#eef3f8' fs solid border lc rgb '#1f4e79' "
         "behind\n"
         "plot " +
         from +
         "($2*1e3):($3*1e3):($2*400):($3*400) with vectors nohead dt 3 lc rgb '#b0b0b0' notitle, " +
         from +
         "($2*1e3):($3*1e3):($11*15):($12*15) with vectors head filled size 3,18 ls 2 "
         "title 'rendered force, 15 mm/N'\n";
}

std::string sphere_script(int figure, const std::string& run, const std::string& title) {
  return output("figure" + std::to_string(figure), 800, 800) + sphere_panel(run, title);
}

constexpr std::array<const char*, 5> kModeTitles = {"none", "total_energy (Eq. 1)",
                                                    "per_axis (Eq. 2)",
                                                    "per_axis_projected (Eq. 3)", "contact_frame"};

std::string mode_run(const std::string& group, std::size_t mode) {
  return group + "_" + std::string(kFigureModes[mode]);
}

std::string all_wall_modes(const std::string& group) {
  std::string script =
      output("wall_modes", 1100, 1250) +
      "set multiplot layout 5,2 title 'The wall, 40 kN/m, b = 2 N s/m: depth and normal force'\n"
      "set xrange [3:7]\nset xlabel 'time [s]'\n";
  for (std::size_t i = 0; i < kModeTitles.size(); ++i) {
    const std::string csv = "'" + mode_run(group, i) + ".csv' skip 1 using 1:";
    script += "unset key\nset title '" + std::string(kModeTitles[i]) + "' noenhanced\n" +
              "set ylabel 'y position [mm]'\nset yrange [-1.4:0.6]\nplot " + csv +
              "($3*1e3) with lines ls 1\nset yrange [*:*]\nset key top right opaque\n" +
              "set ylabel 'y force [N]'\nplot " + csv +
              "($6+$9) with lines ls 3 title 'commanded', " + csv +
              "12 with lines ls 2 title 'rendered'\n";
  }
  return script + "unset multiplot\n";
}

std::string all_sphere_modes(const std::string& group) {
  std::string script =
      output("sphere_modes", 1500, 1050) +
      "set multiplot layout 2,3 title 'The sphere, 5 kN/m, b = 0.5 N s/m: force on the hand'\n";
  for (std::size_t i = 0; i < kModeTitles.size(); ++i) {
    std::string title;
    for (const char c : std::string(kModeTitles[i]))
      title += c == '_' ? "\\\\_" : std::string(1, c);
    script += sphere_panel(mode_run(group, i), title);
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

void draw_figures(const std::filesystem::path& directory) {
  plot(directory, "figure2",
       wall_script(2, "wall_b0.5_total_energy",
                   "Figure 2: stiff wall with friction, bounded by the total energy only, Eq. (1): "
                   "y buzzes, and "
                   "nothing acts"));
  plot(directory, "figure3",
       wall_script(3, "wall_b0.5_per_axis",
                   "Figure 3: the same wall, every axis passive by itself, Eq. (2)"));
  plot(directory, "figure5",
       sphere_script(5, "sphere_b0.5_per_axis", "Figure 5: per axis, before the projection"));
  plot(directory, "figure6",
       sphere_script(6, "sphere_b0.5_per_axis_projected",
                     "Figure 6: projected onto the commanded direction, Eq. (3)"));
  plot(directory, "wall_modes", all_wall_modes("wall_b2"));
  plot(directory, "sphere_modes", all_sphere_modes("sphere_b0.5"));
}

}  // namespace feltwire
