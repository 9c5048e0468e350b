// feltwire-lab torque: the study of six degrees of freedom.

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
      "torque", "Torque that each law renders, and energy of the port of six degrees of freedom");
  command->footer(
      "Eight rotating hands: against the stops of a joint and with bodies in the hand, by law x "
      "delay,\nforce and torque accounted as one port and as two; and whole "
      "sessions over two links. Writes torque.json,\ntorque.csv and torque_sessions.csv, the "
      "same "
      "bytes every time; some minutes of CPU. Exit status 1 when a\nport that is bounded made "
      "energy. docs/lab/torque.md says how to read it.");
  command->add_option("--out", *out, "Folder to write to; created when missing")
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
