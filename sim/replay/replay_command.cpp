#include "sim/replay/replay_command.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/scene_file/load_scene.hpp"
#include "protocol/net/clock.hpp"
#include "sim/replay/replay_report.hpp"

namespace feltwire {

void add_replay(CLI::App& app, std::ostream& out, int& status) {
  struct Options {
    std::vector<std::filesystem::path> files;
    std::string scene;
    bool json = false;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "replay", "Compute the replies of a server's recording again, and compare them bit by bit");
  command->footer(
      "Give all files of one scene's recording, in their order. Exit status 0: all replies are\n"
      "equal. Exit status 1: some differ. Examples:\n"
      "  feltwire-lab replay room.mcap\n"
      "  feltwire-lab replay room-0001.mcap room-0002.mcap --json");
  command->add_option("FILE", o->files, "MCAP files that feltwire-server --record wrote")
      ->required();
  command->add_option("--scene", o->scene,
                      "Scene file that replaces the scene of the recording, also at reloads");
  command->add_flag("--json", o->json, "Print the result as JSON");
  command->callback([o, &out, &status] {
    const auto begin = monotonic_now();
    const Replay result = replay(
        o->files, o->scene.empty() ? nullptr : std::make_shared<const Scene>(load_scene(o->scene)));
    const double took = seconds(monotonic_now() - begin);
    out << (o->json ? replay_json(result, took) : replay_text(result, took));
    status = result.bit_equal() ? 0 : 1;
  });
}

}  // namespace feltwire
