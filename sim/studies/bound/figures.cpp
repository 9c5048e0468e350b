#include "sim/studies/bound/figures.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/base/text.hpp"
#include "core/bounding/device_account.hpp"
#include "core/scene_file/load_scene.hpp"
#include "scenes/paper_sphere_text.hpp"
#include "scenes/paper_wall_text.hpp"
#include "sim/studies/bound/figure_plots.hpp"

namespace feltwire {
namespace {

struct Experiment {
  std::string name;
  std::array<int, 2> figures;      // figure numbers in the paper
  std::array<double, 3> dampings;  // device damping b [N s/m]
};
const std::array<Experiment, 2> kExperiments = {
    {{"wall", {2, 3}, {0.5, 2.0, 8.0}}, {"sphere", {5, 6}, {0.2, 0.5, 2.0}}}};

void write_samples(const std::filesystem::path& file,
                   const std::vector<ExperimentSample>& samples) {
  std::ofstream out(file);
  out << "t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,energy_x,energy_y,energy_z,port_x,port_y,port_z\n";
  // [J] Energy that flows into the port: `energy` by the rendered force, `port` by the held force.
  Vec3 energy = Vec3::Zero(), port = Vec3::Zero();
  std::array<char, 512> line;
  for (const ExperimentSample& s : samples) {
    const Vec3 r = s.rendered.force();
    const Vec3 &e = s.commanded.elastic, &f = s.commanded.frictional;
    energy -= r.cwiseProduct(s.displacement);
    port -= s.held.cwiseProduct(s.displacement);
    const int length =
        std::snprintf(line.data(), line.size(),
                      "%.4f,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%"
                      ".7g,%.7g,%.7g,%.7g\n",
                      s.time, s.position.x(), s.position.y(), s.position.z(), e.x(), e.y(), e.z(),
                      f.x(), f.y(), f.z(), r.x(), r.y(), r.z(), energy.x(), energy.y(), energy.z(),
                      port.x(), port.y(), port.z());
    out.write(line.data(), length);
  }
  out.flush();
  if (!out)
    throw std::runtime_error("cannot write " + file.string() +
                             "; check the folder and the space left");
}

nlohmann::ordered_json entry(int figure, const FigureRun& run) {
  const ExperimentMetrics& m = run.metrics;
  const auto axes = [](const Vec3& v, double unit) {
    return nlohmann::ordered_json::array({v.x() * unit, v.y() * unit, v.z() * unit});
  };
  return {{"figure", figure},
          {"mode", run.mode},
          {"damping", run.damping},
          {"highpass_rms_um", axes(m.highpass_rms, 1e6)},
          {"min_energy_j", axes(m.min_energy, 1.0)},
          {"total_energy_j", m.total_energy},
          {"min_port_energy_j", axes(m.min_port_energy, 1.0)},
          {"port_energy_j", m.port_energy},
          {"min_port_margin_j", m.min_port_margin},
          {"direction_error_deg",
           {{"mean", m.direction_error.mean * kDegrees},
            {"p99", m.direction_error.p99 * kDegrees},
            {"max", m.direction_error.max * kDegrees}}},
          {"force_ratio", m.force_ratio},
          {"outside_bounds_share", m.outside_bounds_share}};
}

}  // namespace

ExperimentSetup figure_setup(const std::string& experiment, std::string_view mode, double damping,
                             Projection projection) {
  ExperimentSetup setup;
  setup.hand.spec = builtin_device("simulated");
  setup.hand.spec.damping = damping;
  HandTask& task = setup.hand.task;
  task.along = Vec3::UnitX();
  if (experiment == "wall") {
    setup.duration = 8.0;
    task.path = HandPath::slide;
    task.normal = Vec3::UnitY();
    task.radius = 0.03;
    task.frequency = 0.5;
    task.depth = 0.01;  // [m] a hand of 300 N/m then presses with 3 N
    task.lead_in = 2.0;
  } else {
    setup.duration = 16.0;  // [s] two turns around the sphere
    task.path = HandPath::orbit;
    task.normal = Vec3::UnitZ();
    task.radius = 0.08;  // [m] 10 mm inside the sphere, so the hand presses with 3 N
    task.frequency = 0.125;
    task.depth = 0.0;
    task.clearance = 0.02;
  }
  setup.bounding.mode = mode;
  setup.bounding.projection = projection;
  setup.bounding.period = 1e-3;
  setup.bounding.damping = damping;
  if (mode == kSessionMethod)
    setup.account = account_config(setup.hand.spec, setup.bounding.period);
  return setup;
}

FigureRun run_figure(const std::string& experiment, std::string_view mode, double damping) {
  const Scene scene = experiment == "wall"
                          ? parse_scene(embedded::paper_wall, "paper_wall.json")
                          : parse_scene(embedded::paper_sphere, "paper_sphere.json");
  const ExperimentSetup setup = figure_setup(experiment, mode, damping);
  FigureRun run{experiment, mode, damping, run_experiment(scene, setup), {}};
  const double c = damping / setup.bounding.period;
  run.metrics = measure(run.samples, {c, c}, damping, setup.bounding.period);
  return run;
}

std::vector<FigureRun> write_figures(const std::filesystem::path& directory) {
  std::filesystem::create_directories(directory);
  std::vector<FigureRun> runs;
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Experiment& experiment : kExperiments) {
    const std::size_t first = runs.size();
    for (const double damping : experiment.dampings) {
      for (const std::string_view mode : kFigureModes) {
        FigureRun run = run_figure(experiment.name, mode, damping);
        write_samples(directory / (run_name(run) + ".csv"), run.samples);
        run.samples.clear();
        run.samples.shrink_to_fit();
        runs.push_back(std::move(run));
      }
    }
    // The paper shows each experiment in two figures. The JSON file lists all runs for both
    // figures.
    for (const int figure : experiment.figures)
      for (std::size_t i = first; i < runs.size(); ++i) json.push_back(entry(figure, runs[i]));
  }
  write_text(directory / "figures.json", json.dump(1) + '\n');
  draw_figures(directory, runs);
  return runs;
}

std::string figures_table(const std::vector<FigureRun>& runs) {
  std::string table =
      "            b                      oscillation  direction   rendered/  outside     least "
      "axis\n"
      "experiment  [Ns/m]  mode               [um]     error[deg]  commanded  axis bounds  energy "
      "[J]\n";
  std::string last;
  for (const FigureRun& run : runs) {
    const std::string group = run_group(run);
    if (!last.empty() && group != last) table += '\n';
    last = group;
    const ExperimentMetrics& m = run.metrics;
    // The hand oscillates along the normal y of the wall. On the sphere, it oscillates in the plane
    // of its path.
    const double oscillation = run.experiment == "wall"
                                   ? m.highpass_rms.y()
                                   : std::max(m.highpass_rms.x(), m.highpass_rms.y());
    append(table, "%-10s  %6.1f  %-18s %8.2f  %9.2f  %9.2f  %9.0f %%  %11.4f\n",
           run.experiment.c_str(), run.damping, std::string(run.mode).c_str(), oscillation * 1e6,
           m.direction_error.mean * kDegrees, m.force_ratio, 100.0 * m.outside_bounds_share,
           m.min_port_energy.minCoeff());
  }
  return table;
}

}  // namespace feltwire
