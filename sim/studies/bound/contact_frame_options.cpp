#include "sim/studies/bound/contact_frame_options.hpp"

#include <algorithm>

#include "core/base/text.hpp"
#include "sim/studies/bound/figures.hpp"

namespace feltwire {
namespace {

/// Returns a scene with a plane. Its outward normal is +y, like the normal of the wall in
/// paper_wall.json.
Scene plane(double stiffness, double friction) {
  Object object;
  object.name = "plane";
  object.shape = Plane{};
  object.pose.orientation = turn_to(Vec3::UnitZ(), Vec3::UnitY());
  object.material = {.stiffness = stiffness,
                     .damping = 0.0,
                     .static_friction = friction,
                     .dynamic_friction = 0.8 * friction,
                     .viscous_friction = 0.0};
  return Scene("plane", {object});
}

Scene sphere(double stiffness) {
  Object object;
  object.name = "sphere";
  object.shape = Sphere{0.09};
  object.material.stiffness = stiffness;
  return Scene("sphere", {object});
}

struct Variant {
  const char* name;
  std::string_view mode;
  Projection projection;
  Storage storage;
};
constexpr Variant kNone{"none", kUnbounded, Projection::joint, Storage::minimal};
constexpr Variant kJoint{"joint", kDefaultMethod, Projection::joint, Storage::minimal};
constexpr Variant kCone{"cone", kDefaultMethod, Projection::cone, Storage::minimal};
constexpr Variant kElastic{"elastic", kDefaultMethod, Projection::cone, Storage::elastic};

ExperimentSetup setup_of(const char* experiment, const Variant& method, double damping) {
  ExperimentSetup setup = figure_setup(experiment, method.mode, damping, method.projection);
  setup.bounding.storage = method.storage;
  return setup;
}

constexpr double kSettled = 3.0;  // [s] time after which the hand is in contact

double mean_normal_force(const std::vector<ExperimentSample>& samples) {
  double sum = 0.0;
  int count = 0;
  for (const ExperimentSample& s : samples) {
    if (s.time < kSettled) continue;
    sum += s.rendered.force().y();
    ++count;
  }
  return sum / count;
}

/// Returns the ratio of rendered to commanded force along the normal of the plane. `sign` > 0: in
/// the samples in which the hand moves outward; `sign` < 0: in which it moves inward.
double share(const std::vector<ExperimentSample>& samples, double sign) {
  double rendered = 0.0, commanded = 0.0;
  for (const ExperimentSample& s : samples) {
    if (s.displacement.y() * sign <= 0.0) continue;
    rendered += s.rendered.force().y();
    commanded += s.commanded.force().y();
  }
  return commanded > 0.0 ? rendered / commanded : 0.0;
}

void projections(std::string& text) {
  text +=
      "Joint or cone: a hand that presses 10 mm deep slides by +-30 mm at 0.5 Hz over dry "
      "friction.\n\n"
      "stiffness  friction  b                normal     direction error\n"
      "[N/m]                [N s/m]  method  force [N]  mean / p99 [deg]\n";
  for (const double stiffness : {500.0, 1000.0, 3000.0})
    for (const double friction : {0.3, 0.6})
      for (const double damping : {0.5, 2.0})
        for (const Variant& method : {kNone, kJoint, kCone}) {
          const auto samples =
              run_experiment(plane(stiffness, friction), setup_of("wall", method, damping));
          const ExperimentMetrics m = measure(samples, {}, damping, 1e-3);
          append(text, "%9.0f  %8.1f  %7.1f  %-6s  %9.2f  %5.2f / %5.2f\n", stiffness, friction,
                 damping, method.name, mean_normal_force(samples),
                 m.direction_error.mean * kDegrees, m.direction_error.p99 * kDegrees);
        }
}

void storages(std::string& text) {
  text +=
      "\nMinimal or elastic: a hand taps 10 mm deep at 0.5 Hz, b = 0.5 N s/m (c = 1000 N/m), with "
      "the\ncommand a round trip old. Rendered over commanded force.\n\n"
      "stiffness  round trip    minimal           elastic\n"
      "[N/m]      [ms]          press / release   press / release\n";
  for (const double stiffness : {100.0, 350.0, 1000.0, 4000.0})
    for (const int delay : {0, 10, 50}) {
      append(text, "%9.0f  %10d", stiffness, delay);
      for (const Variant& method : {kCone, kElastic}) {
        ExperimentSetup setup = setup_of("wall", method, 0.5);
        setup.hand.task.path = HandPath::taps;
        setup.delay = delay;
        const auto samples = run_experiment(plane(stiffness, 0.0), setup);
        append(text, "     %5.2f / %5.2f", share(samples, -1.0), share(samples, 1.0));
      }
      text += '\n';
    }
  text +=
      "\nThe same, gliding round a sphere of 90 mm and 1 kN/m, b = 0.5 N s/m: high-pass RMS of "
      "the\n"
      "position [um], and mean rendered over commanded force.\n\n"
      "round trip [ms]   none           minimal        elastic\n";
  for (const int delay : {0, 10, 50, 100}) {
    append(text, "%15d", delay);
    for (const Variant& method : {kNone, kCone, kElastic}) {
      ExperimentSetup setup = setup_of("sphere", method, 0.5);
      setup.delay = delay;
      const ExperimentMetrics m =
          measure(run_experiment(sphere(1000.0), setup), {}, 0.5, setup.bounding.period);
      append(text, "   %6.1f, %4.2f", 1e6 * std::max(m.highpass_rms.x(), m.highpass_rms.y()),
             m.force_ratio);
    }
    text += '\n';
  }
}

}  // namespace

std::string contact_frame_options_tables() {
  std::string text;
  projections(text);
  storages(text);
  return text;
}

}  // namespace feltwire
