#include "sim/studies/bound/torque_figures.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/text.hpp"
#include "core/base/units.hpp"
#include "sim/report/plot.hpp"

namespace feltwire {
namespace {

constexpr double kComparable = 1e-4;  // [N m] no direction error is computed for smaller torques

std::string csv(const std::vector<SixDofSample>& samples) {
  std::string text = "t,ax,ay,az,ex,ey,ez,rx,ry,rz\n";
  for (const SixDofSample& s : samples) {
    const Vec3 a = rotation_between(Quaternion::Identity(), s.pose.orientation);
    const Vec3 &e = s.commanded.torque, &r = s.rendered.torque;
    append(text, "%.4f,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g\n", s.time, a.x(), a.y(), a.z(),
           e.x(), e.y(), e.z(), r.x(), r.y(), r.z());
  }
  return text;
}

std::string cone_stem(std::string_view mode) { return "torque_cone_" + std::string(mode); }

std::string torque_output(const std::string& file, int width, int height) {
  return "set terminal pngcairo size " + std::to_string(width) + "," + std::to_string(height) +
         " font 'Sans,11'\nset output '" + file +
         ".png'\nset datafile separator ','\nset grid lc rgb '#dddddd'\nset key top right\n";
}

/// Returns the gnuplot text of a panel with an arrow of the rendered torque for each 40 ms of the
/// last turn. Dotted rays show the correct directions.
std::string cone_panel(std::string_view mode, const std::string& title) {
  const std::string from = "'" + cone_stem(mode) + ".csv' skip 1 every 40::4000 using ";
  return "set title \"" + title +
         "\" noenhanced\nset size ratio -1\nset xrange [-0.4:0.4]\nset yrange [-0.4:0.4]\n"
         "set xlabel 'lean about x [rad]'\nset ylabel 'lean about y [rad]'\n"
         "set object 1 circle at 0,0 size 0.2 fc rgb '#eef3f8' fs solid border lc rgb '#1f4e79' "
         "behind\nplot " +
         from +
         "($2):($3):(-$2*0.7):(-$3*0.7) with vectors nohead dt 3 lc rgb '#808080' "
         "title 'correct direction', " +
         from +
         "($2):($3):($8*1.2):($9*1.2) with vectors head filled size 0.01,18 lc rgb '#c0392b' lw "
         "1.2 title 'rendered torque, 1.2 rad per N m'\n";
}

void draw(const std::filesystem::path& directory, const std::vector<TorqueFigure>& figures) {
  plot(directory, "torque_figure5",
       torque_output("torque_figure5", 800, 800) +
           cone_panel("per_axis", "Torque on a joint's stop: per axis, before the projection"));
  plot(directory, "torque_figure6",
       torque_output("torque_figure6", 800, 800) +
           cone_panel("per_axis_projected",
                      "Torque on a joint's stop: projected onto the commanded direction, Eq. (3)"));
  std::string script = torque_output("torque_modes", 1500, 1050) + "set multiplot layout 2,3\n";
  for (const TorqueFigure& figure : figures) {
    std::string title(figure.mode);
    append(title, ": %.0f %% of the torque, %.0f degrees off", 100.0 * figure.torque_share,
           figure.direction_error.mean * kDegrees);
    script += cone_panel(figure.mode, title);
  }
  plot(directory, "torque_modes", script + "unset multiplot\n");
}

}  // namespace

TorqueFigure run_torque_figure(std::string_view mode) {
  TorqueCase made{.law = std::string(mode), .account = mode == kSessionMethod};
  TorqueTask task = joint_tasks(made.stiffness)[1];
  task.duration = 8.0;
  task.hand.frequency = 0.25;
  const SixDofSetup setup = torque_setup(made, task);
  TorqueFigure figure{.mode = mode, .samples = run_six_dof(task.touch, setup)};
  double along = 0.0, whole = 0.0;
  std::vector<double> errors;
  for (std::size_t n = figure.samples.size() / 2; n < figure.samples.size(); ++n) {
    const Vec3 &e = figure.samples[n].commanded.torque, &r = figure.samples[n].rendered.torque;
    along += r.dot(e);
    whole += e.squaredNorm();
    if (e.norm() > kComparable && r.norm() > kComparable) errors.push_back(angle_between(r, e));
  }
  figure.torque_share = whole > 0.0 ? along / whole : 0.0;
  figure.direction_error = spread(std::move(errors));
  figure.energy_made = energy_made(setup.hand.spec, figure.samples, setup.bounding.period).torque;
  return figure;
}

std::vector<TorqueFigure> write_torque_figures(const std::filesystem::path& directory) {
  std::filesystem::create_directories(directory);
  std::vector<TorqueFigure> figures;
  figures.reserve(kFigureModes.size());
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const std::string_view mode : kFigureModes) {
    TorqueFigure figure = run_torque_figure(mode);
    write_text(directory / (cone_stem(mode) + ".csv"), csv(figure.samples));
    figure.samples = {};
    json.push_back({{"mode", mode},
                    {"torque_share", figure.torque_share},
                    {"direction_error_deg",
                     {{"mean", figure.direction_error.mean * kDegrees},
                      {"p99", figure.direction_error.p99 * kDegrees},
                      {"max", figure.direction_error.max * kDegrees}}},
                    {"energy_made_j", figure.energy_made}});
    figures.push_back(std::move(figure));
  }
  write_text(directory / "torque_figures.json", json.dump(1) + '\n');
  draw(directory, figures);
  return figures;
}

std::string torque_figures_table(const std::vector<TorqueFigure>& figures) {
  std::string table =
      "\nTorque on a joint's stop, 8 N m/rad, b_r = 8e-4 N m s/rad\n"
      "mode                rendered/  direction error [deg]  energy made\n"
      "                    commanded   mean    p99    max    [mJ]\n";
  for (const TorqueFigure& f : figures)
    append(table, "%-18s  %9.2f  %5.1f  %5.1f  %5.1f  %9.3f\n", std::string(f.mode).c_str(),
           f.torque_share, f.direction_error.mean * kDegrees, f.direction_error.p99 * kDegrees,
           f.direction_error.max * kDegrees, f.energy_made * kMilli);
  return table;
}

}  // namespace feltwire
