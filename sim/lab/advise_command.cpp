// The command feltwire-lab advise. It recommends settings for a device, a link and a scene.

#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/device/device_file.hpp"
#include "core/scene_file/load_scene.hpp"
#include "sim/lab/study_commands.hpp"
#include "sim/studies/advise/advice_check.hpp"
#include "sim/studies/advise/advice_report.hpp"
#include "sim/studies/advise/link_of_report.hpp"

namespace feltwire {
namespace {

struct AdviseOptions {
  std::string device, link, scene, out;
  int hands = 1, cores = 1;
  double most_rate = 4000.0;
  bool json = false, check = false;
  advise::CheckOptions checked;
};

void give_advice(const AdviseOptions& o) {
  if (o.device.empty() || o.link.empty() || o.scene.empty())
    throw std::invalid_argument("give --device, --link and --scene, or --check without them");
  const advise::Question question{.device = device_spec(o.device),
                                  .link = advise::link_of(o.link),
                                  .hands = o.hands,
                                  .cores = o.cores,
                                  .most_rate = o.most_rate};
  advise::validate(question);
  const Scene scene = load_scene(o.scene);
  const advise::Sources sources{o.device, o.scene};
  const advise::Advice advice = advise::advise(question, scene, advise::start_places(scene));
  std::cout << (o.json ? advise::advice_json(question, sources, advice)
                       : advise::advice_text(question, sources, advice));
  if (o.out.empty()) return;
  advise::write_advice(o.out, question, sources, advice);
  if (!o.json) std::cout << placed("Page, picture and configuration files", o.out);
}

void check(const AdviseOptions& o) {
  const auto cases = advise::check_advice(o.checked);
  std::cout << advise::check_table(cases);
  if (o.out.empty()) return;
  advise::write_check(o.out, cases);
  std::cout << placed("Tables and picture", o.out);
}

}  // namespace

void add_advise(CLI::App& app) {
  auto o = std::make_shared<AdviseOptions>();
  CLI::App* command = app.add_subcommand(
      "advise", "Recommend settings for a device, a link and a scene, and predict their result");
  command->footer(
      "Prints one page: the law, servo rate and traffic to set, the stiffness that a hand will\n"
      "feel of each material and what limits it, delays, bandwidth, CPU time and memory, each "
      "with\n"
      "an error band. With --out: writes advice.txt, advice.json, advice.png, and client.json and\n"
      "server.json for the option --config of the programs. Computing times are measured on this\n"
      "machine for a second; all else is deterministic.\n"
      "With --check: draws devices, links, scenes and hands, runs whole sessions with the advised\n"
      "settings, and prints the error of each prediction. docs/lab/advise.md explains it.\n" +
      link_help());
  CLI::Option* device = command->add_option(
      "--device", o->device, "Specification of the device: a built-in name or FILE.json");
  CLI::Option* link = command->add_option(
      "--link", o->link,
      "Link between client and server: a profile, KEY=VALUE,..., trace:FILE.csv, or a "
      "report of feltwire-client, FILE.json");
  CLI::Option* scene = command->add_option("--scene", o->scene, "Scene file");
  CLI::Option* hands = command->add_option("--hands", o->hands, "Number of hands in the scene")
                           ->capture_default_str();
  CLI::Option* cores = command->add_option("--cores", o->cores, "Number of cores of the server")
                           ->capture_default_str();
  CLI::Option* rate =
      command->add_option("--most-rate", o->most_rate, "[Hz] Highest servo rate that is compared")
          ->capture_default_str();
  CLI::Option* json = command->add_flag("--json", o->json, "Print JSON");
  command->add_option("--out", o->out,
                      "Folder for the results. It is created if it is missing. Default: none");
  CLI::Option* check_it = command->add_flag("--check", o->check, "Check the advice on drawn cases");
  for (CLI::Option* option : {device, link, scene, hands, cores, rate, json})
    check_it->excludes(option);
  command->add_option("--cases", o->checked.cases, "Number of drawn cases; half of them are judged")
      ->needs(check_it)
      ->capture_default_str();
  command
      ->add_option("--searched", o->checked.searched,
                   "Number of judged cases of which all settings are tried")
      ->needs(check_it)
      ->capture_default_str();
  command->add_option("--seed", o->checked.seed, "Seed of the first case")
      ->needs(check_it)
      ->capture_default_str();
  command->callback([o] {
    if (o->check)
      check(*o);
    else
      give_advice(*o);
  });
}

}  // namespace feltwire
