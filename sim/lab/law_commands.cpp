// The commands of feltwire-lab that judge bounding laws, also those of users.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>

#include "client/hands/plant_file.hpp"
#include "core/base/enum_names.hpp"
#include "core/device/device_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "sim/lab/study_commands.hpp"
#include "sim/own_laws/library_law.hpp"
#include "sim/own_laws/own_law.hpp"
#include "sim/own_laws/socket_law.hpp"
#include "sim/studies/bound/compare.hpp"
#include "sim/studies/bound/extremes.hpp"
#include "sim/studies/extremes/extreme_parts.hpp"
#include "sim/studies/network/methods_over_link.hpp"

namespace feltwire {
namespace {

/// The laws of a user, and the built-in ones that are judged with them.
struct JudgedLaws {
  std::vector<std::string> files, methods;
  std::string socket;

  bool given() const { return !files.empty() || !socket.empty() || !methods.empty(); }

  /// Adds the laws of the user to the registry. Returns their names.
  std::vector<std::string_view> load() const {
    const std::size_t built_in = bounding_method_names().size();
    for (const std::string& file : files) add_library_law(file);
    int number = 0, count = 0;
    if (!socket.empty()) {
      if (std::sscanf(socket.c_str(), "%d:%d", &number, &count) != 2)
        throw std::invalid_argument("--law-socket takes FD:COUNT, got " + socket);
      add_socket_laws(number, count);
    }
    std::vector<std::string_view> names = bounding_method_names();
    names.erase(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(built_in));
    return names;
  }
};

void add_law_options(CLI::App& command, JudgedLaws& laws) {
  command.add_option("--law", laws.files,
                     "FILE.so with a bounding law of your own (docs/own_bounding_law.md). May be "
                     "given several times");
  command
      .add_option("--law-socket", laws.socket,
                  "FD:COUNT. The laws of the process that started this one, over an open socket")
      ->group("");
  command.add_option("--methods", laws.methods, "Judge only these methods and the laws of --law")
      ->delimiter(',');
}

std::vector<CompareTask> tasks_named(const std::vector<std::string>& names) {
  std::vector<CompareTask> all = compare_tasks();
  if (names.empty()) return all;
  std::vector<CompareTask> chosen;
  chosen.reserve(names.size());
  for (const std::string& name : names)
    chosen.push_back(get_named("task", name, all, &CompareTask::name));
  return chosen;
}

std::vector<Method> compared_methods(const JudgedLaws& laws) {
  std::vector<Method> chosen;
  const std::vector<std::string_view> own = laws.load();
  if (!laws.methods.empty())
    for (const std::string& label : laws.methods) chosen.push_back(method(label));
  else if (own.empty())
    chosen.assign(methods().begin(), methods().end());
  else
    chosen = {method("none"), method("contact_frame")};
  for (const std::string_view name : own) chosen.push_back({name});
  return chosen;
}

std::vector<std::string_view> judged_methods(const JudgedLaws& laws) {
  std::vector<std::string_view> chosen;
  for (const std::string& name : laws.methods) chosen.push_back(bounding_method(name).name);
  for (const std::string_view own : laws.load()) chosen.push_back(own);
  return chosen.empty() ? bounding_method_names() : chosen;
}

}  // namespace

void add_compare(CLI::App& app) {
  struct Options {
    std::string out = "compare";
    CompareLoop loop;
    double delay_ms = 0.0;
    std::string scene, link, device = "simulated", plant, path = "press";
    double press = 3.0, duration = 4.0;
    JudgedLaws laws;
    std::vector<std::string> tasks;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "compare",
      "Compare all methods on walls, edges, bumps, friction and a tap, or in your own scene");
  command->footer(
      "Without --scene: writes compare.json, compare.csv, compare.png, compare_hands.csv (eight\n"
      "hands), and the times on this machine to compare_cost.csv. All results but the cost are\n"
      "deterministic. docs/lab/laboratory.md explains them.\n"
      "With --law, --methods or --tasks: only these, without picture and compare_hands.csv. "
      "Beside\n"
      "a --law stand none and contact_frame, if --methods names no others.\n"
      "With --scene: runs whole sessions over the link in virtual time. Writes\n"
      "methods_over_link.csv and .json, which are deterministic. Example:\n"
      "  feltwire-lab compare --scene scenes/bunny.json --link delay=15,loss=2 --device simulated");
  add_out(*command, o->out);
  CLI::Option* scene = command->add_option("--scene", o->scene, "Scene file that the hand touches");
  command->add_option("--link", o->link, "Emulated network between hand and scene (docs/link.md)")
      ->needs(scene);
  command
      ->add_option("--device", o->device,
                   "Specification of the device: a built-in name or FILE.json (docs/devices.md)")
      ->needs(scene)
      ->capture_default_str();
  command
      ->add_option("--plant", o->plant,
                   "FILE.json with the motor lag, the transmission and more (docs/devices.md). The "
                   "methods do not get these values")
      ->needs(scene);
  command
      ->add_option("--path", o->path, "Movement of the hand: press|slide|orbit|figure-eight|taps")
      ->needs(scene)
      ->capture_default_str();
  command->add_option("--press", o->press, "[N] Force by which the hand presses")
      ->needs(scene)
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  command->add_option("--duration", o->duration, "[s] Length of each session")
      ->needs(scene)
      ->capture_default_str();
  command->add_option("--damping", o->loop.damping, "[N s/m] Damping b of the device")
      ->capture_default_str()
      ->excludes(scene);
  add_law_options(*command, o->laws);
  for (const char* option : {"--law", "--methods"}) command->get_option(option)->excludes(scene);
  command
      ->add_option("--tasks", o->tasks,
                   "Only these tasks: wall, sphere, corner, edge, torus, stick_slip, tap")
      ->delimiter(',')
      ->excludes(scene);
  command->add_option("--rate", o->loop.rate, "[Hz] Servo rate")->capture_default_str();
  command->add_option("--delay", o->delay_ms, "[ms] Round-trip delay, rounded up to whole samples")
      ->capture_default_str()
      ->excludes(scene);
  command->callback([o] {
    if (o->scene.empty()) {
      o->loop.delay = o->delay_ms * 1e-3;
      if (o->laws.given() || !o->tasks.empty()) {
        const auto rows =
            write_compare(o->out, o->loop, tasks_named(o->tasks), compared_methods(o->laws));
        check_own_laws();
        std::cout << compare_table(rows) << placed("Tables", o->out);
        return;
      }
      const Comparison result = write_compare(o->out, o->loop);
      std::cout << compare_table(result.rows) << compare_hands_table(result.hands)
                << placed("Tables and picture", o->out);
      return;
    }
    const Scene felt = load_scene(o->scene);
    OverLinkTask task{.hand = press_at_start(felt, o->press),
                      .link = parse_link(o->link),
                      .device = device_spec(o->device),
                      .plant = o->plant.empty() ? Plant{} : load_plant(o->plant),
                      .rate = o->loop.rate,
                      .duration = o->duration};
    task.hand.path = hand_path(o->path);
    const auto rows = run_over_link(felt, task);
    write_over_link(o->out, rows);
    std::cout << over_link_table(rows) << placed("Tables", o->out);
  });
}

namespace {

constexpr const char* kBoundPart = "bound";
constexpr const char* kAllParts = "all";

struct ExtremesOptions {
  std::string out = "extremes";
  std::vector<std::string> parts = {kBoundPart};
  double assumed_damping = 1.0, assumed_scale = 1.0;
  int hands = 10;
  JudgedLaws laws;

  bool asks(std::string_view part) const {
    return std::ranges::any_of(
        parts, [&](const std::string& asked) { return asked == part || asked == kAllParts; });
  }
};

std::vector<std::string> part_choices() {
  std::vector<std::string> names = {kBoundPart};
  for (const ExtremePart& part : kExtremeParts) names.emplace_back(part.name);
  names.emplace_back(kAllParts);
  return names;
}

/// Judges the bounding methods. Returns whether every row passed.
bool judge_bounds(const ExtremesOptions& options) {
  const bool all = !options.laws.given();
  const auto rows =
      run_extremes(options.assumed_damping, options.hands, judged_methods(options.laws));
  check_own_laws();
  write_extremes(options.out, rows);
  if (all) draw_extremes(options.out, rows);
  std::cout << extremes_table(rows) << placed(all ? "Table and picture" : "Tables", options.out);
  return all_passed(rows);
}

/// Judges the other parts that are asked for. Returns whether every cell passed.
bool judge_parts(const ExtremesOptions& options) {
  bool passed = true;
  for (const ExtremePart& part : kExtremeParts) {
    if (!options.asks(part.name)) continue;
    const ExtremeMatrix matrix = part.run(options.assumed_scale);
    write_extreme_matrix(options.out, matrix);
    std::cout << extreme_matrix_table(matrix) << placed("Tables", options.out);
    passed = passed && matrix.passed();
  }
  return passed;
}

}  // namespace

void add_extremes(CLI::App& app, int& status) {
  auto o = std::make_shared<ExtremesOptions>();
  CLI::App* command = app.add_subcommand(
      "extremes", "Run all methods at the limits of the number range, in double and float");
  command->footer(
      "Writes extremes.csv, extremes.json and extremes.png. The results are deterministic. Exit\n"
      "status 1: a row rendered NaN, Inf or more than the limit, or violated the energy guarantee\n"
      "of its method. docs/lab/precision.md explains them.\n"
      "With --law or --methods: only these, without picture.\n"
      "With --part: judges other parts of the product at their extremes, against closed forms.\n"
      "Writes extremes_PART.csv and extremes_PART.json. Exit status 1: a cell failed.");
  add_out(*command, o->out);
  command
      ->add_option("--part", o->parts,
                   "Parts to judge: bound, contact, dynamics, wire, local (models), teleoperation, "
                   "all")
      ->delimiter(',')
      ->check(CLI::IsMember(part_choices()))
      ->capture_default_str();
  command
      ->add_option("--assumed-damping", o->assumed_damping,
                   "Damping that the bounds assume, divided by the real damping. Above 1, for "
                   "example 1.05, the rows must fail")
      ->capture_default_str();
  command
      ->add_option("--hands", o->hands,
                   "Number of hands for each stress case. Five kinds of hands take turns")
      ->capture_default_str();
  command
      ->add_option("--assumed-scale", o->assumed_scale,
                   "Closed forms of the other parts, divided by the right ones. Above 1, for "
                   "example 1.05, cells must fail")
      ->capture_default_str();
  add_law_options(*command, o->laws);
  command->callback([o, &status] {
    if (o->laws.given() && !o->asks(kBoundPart))
      throw std::invalid_argument("--law and --methods judge the part bound: add it to --part");
    const bool bounds = !o->asks(kBoundPart) || judge_bounds(*o);
    status = judge_parts(*o) && bounds ? 0 : 1;
  });
}

}  // namespace feltwire
