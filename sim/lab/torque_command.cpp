// The command feltwire-lab torque. It runs the study of force and torque in six degrees of freedom.

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/hands/plant_file.hpp"
#include "core/base/visible_text.hpp"
#include "sim/lab/study_commands.hpp"
#include "sim/studies/bound/torque.hpp"

namespace feltwire {

void add_torque(CLI::App& app, int& status) {
  struct Options {
    std::string out = "torque", plant;
    bool told = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "torque", "Compare the torque and the port energy of each law in six degrees of freedom");
  command->footer(
      "Eight rotating hands turn against joint stops and hold bodies, by law x delay, with force\n"
      "and torque as one port and as two ports. Whole sessions over two links follow. Writes\n"
      "torque.json, torque.csv and torque_sessions.csv. The results are deterministic and take\n"
      "some minutes of CPU time. Exit status 1: a bounded port generated energy.\n"
      "docs/lab/torque.md explains the results.\n"
      "With --plant: runs the cases without delay on a device with this plant, and no sessions.\n"
      "Torque passes the plant's amplifier, rotation has no transmission. The energy is also that "
      "of\n"
      "the true motor.");
  command->add_option("--out", o->out, "Folder for the results. It is created if it is missing")
      ->capture_default_str();
  CLI::Option* plant = command->add_option(
      "--plant", o->plant, "FILE.json with the motor lag, the transmission and more");
  command->add_flag("--told", o->told, "The bounds use the motor lag of the plant")->needs(plant);
  command->callback([o, &status] {
    const bool ideal = o->plant.empty();
    const auto rows =
        run_torque(ideal ? torque_cases() : torque_cases(load_plant(o->plant), o->told));
    std::vector<TorqueSession> sessions;
    if (ideal) sessions = torque_sessions();
    run_sessions(sessions);
    write_torque(o->out, rows, sessions);
    std::cout << torque_table(rows) << (ideal ? torque_sessions_table(sessions) : "")
              << "\nTables are in "
              << visible(std::filesystem::absolute(o->out).lexically_normal().string()) << '\n';
    std::erase_if(sessions, [](const TorqueSession& s) { return s.mode == kUnbounded; });
    status = ports_hold(rows, sessions) ? 0 : 1;
  });
}

}  // namespace feltwire
