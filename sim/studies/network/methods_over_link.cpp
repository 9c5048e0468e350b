#include "sim/studies/network/methods_over_link.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "core/base/text.hpp"
#include "sim/measure/fidelity.hpp"

namespace feltwire {
namespace {

constexpr double kLeastRate = 100.0, kLargestRate = 1e4;  // [Hz] limits of the servo rate
constexpr double kLongest = 600.0;                        // [s] longest duration of a session

constexpr const char* kReference = "reference";
constexpr double kReferenceRate = 1e4;  // [Hz] servo rate of the reference

struct Row {
  const char* label;
  std::string_view mode;
  bool local_model = false, research = false;
  bool as_published = false;  // without the energy account of a session
};
// The table omits the methods that evaluate the scene at another position than that of the device,
// because they cannot work over a link.
constexpr std::array kRows = {
    Row{kReference, "none"},
    Row{"none", "none"},
    Row{.label = "total_energy", .mode = "total_energy", .as_published = true},
    Row{.label = "per_axis", .mode = "per_axis", .as_published = true},
    Row{.label = "per_axis_projected", .mode = "per_axis_projected", .as_published = true},
    Row{"contact_frame", "contact_frame"},
    Row{"contact_frame + local model", "contact_frame", true},
    Row{"shaped", "shaped"},
    Row{"shaped + local model", "shaped", true},
    Row{.label = "passivity_control",
        .mode = "passivity_control",
        .research = true,
        .as_published = true},
    Row{"energy_tank", "energy_tank", false, true},
};

OverLinkRow measure(const Scene& scene, const OverLinkTask& task, const Row& row) {
  NetworkRunOptions options;
  options.hand.spec = task.device;
  options.hand.plant = task.plant;
  options.hand.task = task.hand;
  options.parameters.mode = row.mode;
  options.servo.account = !row.as_published;
  const bool reference = row.label == kReference;
  const double rate = reference ? kReferenceRate : task.rate;
  options.parameters.servo_period = 1.0 / rate;
  options.parameters.local_model = row.local_model;
  if (!reference) options.link = task.link;
  options.duration = task.duration;
  const NetworkRunResult run = run_network(scene, options);
  const Fidelity felt = fidelity(std::span(run.samples).subspan(run.samples.size() / 2));
  return {.label = row.label,
          .research = row.research,
          .oscillation = oscillation(run.samples, rate),
          .energy_made =
              task.plant.ideal() ? std::max(0.0, -run.least_device_margin) : run.true_energy.made,
          .felt = felt.ratio(),
          .error = felt.error,
          .direction_error = felt.direction.mean};
}

void check(const Scene& scene, const OverLinkTask& task) {
  if (scene.requirements().rotation)
    throw std::invalid_argument("scene '" + scene.name() +
                                "': its tool has a body; the comparison feels with a point or a "
                                "ball: remove the tool, or put a point first");
  if (!(task.rate >= kLeastRate && task.rate <= kLargestRate))
    throw std::invalid_argument("the servo rate must be from 100 to 10000 Hz");
  if (!(task.duration >= 1.0 && task.duration <= kLongest))
    throw std::invalid_argument("the duration must be from 1 to 600 s");
}

}  // namespace

HandTask press_at_start(const Scene& scene, double force) {
  HandTask task;
  task.center = scene.start().position;
  set_normal(task, scene.start().normal);
  task.lead_in = 1.0;
  task.depth = force / Hand{}.stiffness;
  if (const double stiffness = scene.requirements().stiffness; stiffness > 0.0)
    task.depth += force / stiffness;  // the hand and the surface are springs in series
  return task;
}

std::vector<OverLinkRow> run_over_link(const Scene& scene, const OverLinkTask& task) {
  check(scene, task);
  std::vector<OverLinkRow> rows(kRows.size());
  parallel_for(rows.size(), [&](std::size_t i) { rows[i] = measure(scene, task, kRows[i]); });
  return rows;
}

std::string over_link_table(const std::vector<OverLinkRow>& rows) {
  std::string text;
  append(text, "%-29s %14s %12s %10s %12s %10s\n", "bounding method", "oscillation", "energy made",
         "force felt", "force error", "direction");
  append(text, "%-29s %14s %12s %10s %12s %10s\n", "", "[um]", "[mJ]", "[%]", "[N]", "[deg]");
  for (const OverLinkRow& row : rows)
    append(text, "%-29s %14.1f %12.2f %10.0f %12.3f %10.1f\n",
           (row.label + (row.research ? " (research)" : "")).c_str(), 1e6 * row.oscillation,
           1e3 * row.energy_made, 100.0 * row.felt, row.error, kDegrees * row.direction_error);
  text +=
      "\nreference: no network, no bound, 10 kHz: what the surface itself does to the numbers.\n"
      "Energy made is what the hand got beyond what the device burned: above zero, the loop can "
      "shake by itself.\nForce felt is the force on the hand over the scene's own where the hand "
      "really was. A passive bound\nwithholds the force that the device's damping does not cover "
      "over this delay. With a local model surfaces\ntravel instead of forces; a mesh travels "
      "whole. total_energy, per_axis, per_axis_projected and\npassivity_control are as published, "
      "without the account of a session (--no-account).\n";
  return text;
}

void write_over_link(const std::filesystem::path& directory, const std::vector<OverLinkRow>& rows) {
  std::filesystem::create_directories(directory);
  std::string csv =
      "method,research,oscillation_m,energy_made_j,force_felt,force_error_n,direction_error_rad\n";
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const OverLinkRow& row : rows) {
    append(csv, "%s,%d,%.9g,%.9g,%.9g,%.9g,%.9g\n", row.label.c_str(), row.research ? 1 : 0,
           row.oscillation, row.energy_made, row.felt, row.error, row.direction_error);
    json.push_back({{"method", row.label},
                    {"research", row.research},
                    {"oscillation_m", row.oscillation},
                    {"energy_made_j", row.energy_made},
                    {"force_felt", row.felt},
                    {"force_error_n", row.error},
                    {"direction_error_rad", row.direction_error}});
  }
  write_text(directory / "methods_over_link.csv", csv);
  write_text(directory / "methods_over_link.json", json.dump(2) + "\n");
}

}  // namespace feltwire
