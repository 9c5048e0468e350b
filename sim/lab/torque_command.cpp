// The command feltwire-lab torque. It runs the study of force and torque in six degrees of freedom.

#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "core/base/visible_text.hpp"
#include "sim/lab/study_commands.hpp"
#include "sim/studies/bound/torque.hpp"

namespace feltwire {

void add_torque(CLI::App& app, int& status) {
  auto out = std::make_shared<std::string>("torque");
  CLI::App* command = app.add_subcommand(
      "torque", "Compare the torque and the port energy of each law in six degrees of freedom");
  command->footer(
      "Eight rotating hands turn against joint stops and hold bodies, by law x delay, with force\n"
      "and torque as one port and as two ports. Whole sessions over two links follow. Writes\n"
      "torque.json, torque.csv and torque_sessions.csv. The results are deterministic and take\n"
      "some minutes of CPU time. Exit status 1: a bounded port generated energy.\n"
      "docs/lab/torque.md explains the results.");
  command->add_option("--out", *out, "Folder for the results. It is created if it is missing")
      ->capture_default_str();
  command->callback([out, &status] {
    const auto rows = run_torque(torque_cases());
    auto sessions = torque_sessions();
    run_sessions(sessions);
    write_torque(*out, rows, sessions);
    std::cout << torque_table(rows) << torque_sessions_table(sessions) << "\nTables are in "
              << visible(std::filesystem::absolute(*out).lexically_normal().string()) << '\n';
    std::erase_if(sessions, [](const TorqueSession& s) { return s.mode == kUnbounded; });
    status = ports_hold(rows, sessions) ? 0 : 1;
  });
}

}  // namespace feltwire
