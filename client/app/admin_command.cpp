#include "client/app/admin_command.hpp"

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "client/app/admin_requests.hpp"
#include "client/command_line/credential_options.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/token_text.hpp"
#include "core/base/units.hpp"
#include "core/base/visible_text.hpp"
#include "protocol/command_line/command_error.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/strict_values.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "protocol/session/bound_words.hpp"

namespace feltwire {
namespace {

constexpr int kBadUsage = 2, kCannotRun = 1;

constexpr const char* kExamples = R"(
Examples (with the credentials from the server's join: line, and the token of an admin):
  feltwire-client admin sessions --connect localhost:6720
  feltwire-client admin set --connect localhost:6720 --object table --stiffness 500
  feltwire-client admin set --connect localhost:6720 --gravity 0,0,-1.62
  feltwire-client admin set --connect localhost:6720 --session 1 --mode contact_frame
  feltwire-client admin set --connect localhost:6720 --session 1 --delay 25 --loss 10
  feltwire-client admin set --connect localhost:6720 --session 1 --lead-share 0.5
  feltwire-client admin reload room --connect localhost:6720
  feltwire-client admin record --connect localhost:6720
  feltwire-client admin recording --start --connect localhost:6720
A change takes effect at once. It lasts until the next change or until a reload of the scene. The
file of the scene does not change (docs/admin.md).)";

struct AdminWords {
  std::string connect, scene, session;
  CredentialOptions credentials;
  bool json = false;
  bool start = false, stop = false;  // a recording
  MaterialChange material;
  std::optional<std::array<double, 3>> gravity;
  BoundWords parameters;
  std::optional<double> delay, jitter;  // [ms] mean and standard deviation of the link's delay
  std::optional<double> loss;           // [%] share of lost datagrams
  std::optional<double> lead_share;
  bool link() const { return delay || jitter || loss; }
};

/// Gets the answer of a command, in pieces.
using Write = std::function<void(std::string_view text)>;

/// The answer of a command that changes something: a line, or its values.
void answer(const AdminWords& words, const Write& write, const std::string& line,
            const AnswerFields& fields) {
  write((words.json ? answer_json(fields) : line) + "\n");
}

void list_scenes_of(const ServerAccess& server, const AdminWords& words, const Write& write) {
  const auto scenes = list_scenes(server, kControlTimeout);
  write(words.json ? scene_json(server.endpoint, scenes) : scene_table(server.endpoint, scenes));
}

void list_sessions(const ServerAccess& server, const AdminWords& words, const Write& write) {
  const SeenSessions sessions = sessions_of(server, words.scene);
  if (words.json)
    write_session_json(sessions, write);
  else
    write(session_table(sessions));
}

void reload(const ServerAccess& server, const AdminWords& words, const Write& write) {
  // Longest wait for the answer. The server answers after it has loaded the scene, and large grids
  // and meshes load slowly.
  constexpr std::chrono::minutes kPatience{10};
  ask(server, control::ReloadScene{words.scene}, kPatience);
  answer(words, write, "scene " + visible(words.scene) + " is reloaded",
         {{"scene", visible(words.scene)}});
}

void evict(const ServerAccess& server, const AdminWords& words, const Write& write) {
  const SeenSessions sessions = sessions_of(server, words.scene);
  const SeenSession& seen = session_named(sessions, words.session);
  ask_for<control::Evicted>(server, control::Evict{seen.session.session});
  AnswerFields fields = fields_of(seen);
  fields.emplace_back("client", visible(seen.session.client));
  answer(words, write, text_of(seen) + " (" + visible(seen.session.client) + ") is evicted",
         fields);
}

/// Waits up to 3 s until the client of the session answers the requested change. Throws
/// LastingError if the client refuses the change, and SessionError if it does not answer.
void await_client(const ServerAccess& server, const AdminWords& words, const SeenSession& seen,
                  const Write& write) {
  constexpr int kLooks = 30;
  constexpr std::chrono::milliseconds kBetween{100};
  const std::string name = std::to_string(seen.session.session);
  for (int look = 0; look < kLooks; ++look) {
    const SeenSessions sessions = sessions_of(server, seen.scene);
    const SeenSession& now = session_named(sessions, name);
    const std::string who = "the client of " + text_of(now) + " has ";
    if (now.session.changes.answer == ChangeAnswer::taken) {
      AnswerFields fields = fields_of(now);
      fields.emplace_back("change", visible(now.session.changes.asked));
      return answer(words, write, who + "taken the change: " + visible(now.session.changes.asked),
                    fields);
    }
    if (now.session.changes.answer == ChangeAnswer::refused)
      throw LastingError(who + "refused the change (" + now.session.changes.asked +
                         "): its own output says why (docs/admin.md)");
    std::this_thread::sleep_for(kBetween);
  }
  throw SessionError(
      "the client has not answered for three seconds; the server continues to ask it. See the "
      "result with admin sessions");
}

/// Changes the emulated link of a session. An omitted --delay, --jitter or --loss becomes zero.
void set_link(const ServerAccess& server, const AdminWords& words, const SeenSession& seen,
              const Write& write) {
  if (words.parameters != BoundWords{})
    throw std::invalid_argument(
        "--delay, --jitter and --loss change the link, the other options change the bound; give "
        "them in two commands");
  const LinkQuality link{words.delay.value_or(0.0) / kMilli, words.jitter.value_or(0.0) / kMilli,
                         words.loss.value_or(0.0) / kPercent};
  ask_for<control::SceneChanged>(server, control::SetLink{seen.session.session, link});
  await_client(server, words, seen, write);
}

/// Sends a change of a scene, and tells what the server has changed.
void change(const ServerAccess& server, const AdminWords& words, const std::string& scene,
            const control::Message& request, const Write& write) {
  const std::string what = visible(ask_for<control::SceneChanged>(server, request).what);
  answer(words, write, "scene " + visible(scene) + ": " + what,
         {{"scene", visible(scene)}, {"change", what}});
}

void set_lead(const ServerAccess& server, const AdminWords& words, const SeenSession& seen,
              const Write& write) {
  if (words.parameters != BoundWords{} || words.link())
    throw std::invalid_argument(
        "--lead-share changes the lead of a robot; give the other options in a second command");
  change(server, words, seen.scene, control::SetLead{seen.session.session, *words.lead_share},
         write);
}

void set_session(const ServerAccess& server, const AdminWords& words, const Write& write) {
  const SeenSessions sessions = sessions_of(server, words.scene);
  const SeenSession& seen = session_named(sessions, words.session);
  if (words.lead_share) return set_lead(server, words, seen, write);
  if (words.link()) return set_link(server, words, seen, write);
  const SessionParameters wanted = with_words(seen.session.parameters, words.parameters);
  if (wanted == seen.session.parameters)
    throw std::invalid_argument(
        "--session: the values are the present ones, so nothing would change; give another value, "
        "for example of --mode");
  const auto set =
      ask_for<control::ParametersSet>(server, control::SetParameters{seen.session.session, wanted});
  if (set.parameters != wanted) return await_client(server, words, seen, write);
  answer(words, write, text_of(seen) + " has the new parameters", fields_of(seen));
}

void set(const ServerAccess& server, const AdminWords& words, const Write& write) {
  const bool object = words.material != MaterialChange{}, session = !words.session.empty();
  if (int{object} + int{session} + int{words.gravity.has_value()} != 1)
    throw std::invalid_argument("give one of --object, --gravity and --session");
  if (session) return set_session(server, words, write);
  const std::string scene = scene_named(server, words.scene);
  control::Message request = control::SetMaterial{scene, words.material};
  if (words.gravity)
    request = control::SetGravity{
        scene, Vec3((*words.gravity)[0], (*words.gravity)[1], (*words.gravity)[2])};
  else if (words.material.object.empty())
    throw std::invalid_argument(
        "--object is required; give the name of the object that has this material");
  change(server, words, scene, request, write);
}

/// Makes the server write a flight record of one scene, or of each scene that the token opens.
void record(const ServerAccess& server, const AdminWords& words, const Write& write) {
  std::vector<std::string> records;
  for (const std::string& scene : scenes_named(server, words.scene)) {
    const std::string file = visible(
        ask_for<control::FlightRecordWritten>(server, control::WriteFlightRecord{scene}).file);
    if (words.json)
      records.push_back(answer_json({{"scene", visible(scene)}, {"file", file}}));
    else
      write("scene " + visible(scene) + ": flight record: " + file + "\n");
  }
  if (words.json) write(json_list(records));
}

/// Starts or stops a recording of a scene at the server, or shows the recordings of all scenes that
/// the token opens.
void recordings(const ServerAccess& server, const AdminWords& words, const Write& write) {
  using control::RecordingAction;
  if (words.start && words.stop)
    throw std::invalid_argument("--start and --stop exclude each other; give one of them");
  const RecordingAction action = words.start  ? RecordingAction::start
                                 : words.stop ? RecordingAction::stop
                                              : RecordingAction::look;
  std::vector<std::string> scenes;
  if (action == RecordingAction::look)
    scenes = scenes_named(server, words.scene);
  else
    scenes.push_back(scene_named(server, words.scene));
  std::vector<std::string> texts;
  for (const std::string& scene : scenes) {
    const auto told =
        ask_for<control::SceneRecordings>(server, control::RecordScene{scene, action});
    if (words.json)
      texts.push_back(recordings_json(told));
    else
      write(recordings_lines(told));
  }
  if (words.json) write(json_list(texts));
}

void show_counters(const ServerAccess& server, const AdminWords& words, const Write& write) {
  const std::vector<SeenCounters> counters = counters_of(server);
  write(words.json ? counter_json(counters) : counter_lines(counters));
}

/// The command line of the program. Empty: a library, which knows the server and the credentials.
using CommandLine = std::span<char*>;

/// Adds the options that all commands share.
void add_shared(CLI::App& command, AdminWords& words, CommandLine line) {
  command.add_flag("--json", words.json, "Print JSON");
  if (line.empty()) return;
  command
      .add_option("--connect", words.connect,
                  "HOST:PORT of the server's control port; IPv6 as [::1]:PORT")
      ->required();
  add_credential_options(command, words.credentials);
  read_environment(command, static_cast<int>(line.size()), line.data(),
                   {.shared = credential_variables()}, credential_rivals());
}

void add_material(CLI::App& command, MaterialChange& material) {
  const auto group = "Material of an object";
  command.add_option("--object", material.object, "Name of the object")->group(group);
  command.add_option("--stiffness", material.stiffness, "[N/m] Stiffness")->group(group);
  command.add_option("--damping", material.damping, "[N s/m] Damping")->group(group);
  command
      .add_option("--static-friction", material.static_friction,
                  "Static friction coefficient, at least the dynamic coefficient")
      ->group(group);
  command
      .add_option("--dynamic-friction", material.dynamic_friction, "Dynamic friction coefficient")
      ->group(group);
  command
      .add_option("--viscous-friction", material.viscous_friction,
                  "[N s/m] Viscous friction coefficient")
      ->group(group);
}

void add_link(CLI::App& command, AdminWords& words) {
  const auto group = "Emulated link of a session (of a client with --link)";
  command.add_option("--delay", words.delay, "[ms] Mean delay in each direction. Default: 0")
      ->group(group);
  command.add_option("--jitter", words.jitter, "[ms] Standard deviation of the delay. Default: 0")
      ->group(group);
  command.add_option("--loss", words.loss, "[%] Share of lost datagrams. Default: 0")->group(group);
}

void add_parameters(CLI::App& command, AdminWords& words) {
  const auto group = "Bound of a session. A bound at the client: only mode, projection and storage";
  BoundWords& w = words.parameters;
  command
      .add_option("--session", words.session, "Number or id of the session (see `admin sessions`)")
      ->group(group);
  command.add_option("--mode", w.mode, "Bounding method: " + bounding_method_choices())
      ->group(group);
  command
      .add_option("--projection", w.projection,
                  "Projection of contact_frame: " + joined_names(kProjectionNames))
      ->group(group);
  command
      .add_option("--storage", w.storage,
                  "Energy storage of contact_frame: " + joined_names(kStorageNames))
      ->group(group);
  command
      .add_option("--reference", w.reference,
                  "Reference of passivity_control*: " + joined_names(kPassivityReferenceNames))
      ->group(group);
  command
      .add_option("--operator-damping", w.operator_damping,
                  "[N s/m] Known least damping of the operator's hand. The bound adds it to the "
                  "damping of the device")
      ->group(group);
  command
      .add_option("--velocity-cutoff", w.velocity_cutoff,
                  "[Hz] Cutoff frequency of the server's velocity estimate. 0: no filter. Allowed "
                  "for every session")
      ->group(group);
  command.add_option("--c1", w.c1, "[N/m] Constant c1 of the paper's methods")->group(group);
  command.add_option("--c2", w.c2, "[N/m] Constant c2 of the paper's methods")->group(group);
  command
      .add_option("--coupling-stiffness", w.coupling_stiffness,
                  "[N/m] Stiffness of virtual_coupling")
      ->group(group);
  command
      .add_option("--coupling-damping", w.coupling_damping, "[N s/m] Damping of virtual_coupling")
      ->group(group);
  command
      .add_option("--tool-mass", w.tool_mass, "[kg] Mass of the simulated tool of virtual_coupling")
      ->group(group);
}

void add_lead(CLI::App& command, AdminWords& words) {
  command
      .add_option("--lead-share", words.lead_share,
                  "Weight of this session among the sessions that lead the scene's robot together, "
                  "0.01 to 100. 0: this session leads alone")
      ->group("Lead of a robot");
}

struct AdminCommand {
  CLI::App* command;
  void (*run)(const ServerAccess& server, const AdminWords& words, const Write& write);
};

std::vector<AdminCommand> add_commands(CLI::App& app, AdminWords& words, CommandLine line) {
  const auto add_command = [&](const char* name, const char* does) {
    CLI::App* command = app.add_subcommand(name, does);
    // Add these options first, because environment variables set only the options added so far.
    add_shared(*command, words, line);
    return command;
  };
  CLI::App* scenes = add_command("scenes", "List the scenes that the token opens");
  CLI::App* sessions = add_command("sessions", "List the sessions and their state");
  sessions->add_option("--scene", words.scene, "Show only this scene");
  CLI::App* reloading = add_command("reload", "Reload a scene's file");
  reloading->add_option("SCENE", words.scene, "Name of the scene")->required();
  CLI::App* evicting = add_command("evict", "End a session with a goodbye");
  evicting
      ->add_option("SESSION", words.session, "Number or id of the session (see `admin sessions`)")
      ->required();
  evicting->add_option(
      "--scene", words.scene,
      "Scene of the session. Needed if several scenes have a session with this number");
  CLI::App* setting = add_command("set",
                                  "Change the material of an object, the gravity, or the bound, "
                                  "emulated link or lead share of a session");
  setting->add_option("--scene", words.scene,
                      "Name of the scene. Needed if the server has several scenes");
  add_material(*setting, words.material);
  setting->add_option("--gravity", words.gravity, "X,Y,Z [m/s^2] Gravity on moving objects")
      ->delimiter(',');
  add_parameters(*setting, words);
  add_link(*setting, words);
  add_lead(*setting, words);
  CLI::App* recording = add_command("record",
                                    "Write the last ten seconds of a scene to a file at the server "
                                    "(--flight-recorder), and print the file name");
  recording->add_option("--scene", words.scene, "Name of the scene. Default: all scenes");
  CLI::App* keeping = add_command("recording",
                                  "Show the recordings of the scenes at the server "
                                  "(--recordings), or start or stop one");
  keeping->add_flag("--start", words.start, "Start a recording of the scene");
  keeping->add_flag("--stop", words.stop, "Stop the recording of the scene");
  keeping->add_option(
      "--scene", words.scene,
      "Name of the scene. Needed to start or stop if the server has several scenes");
  CLI::App* counting = add_command("stats", "Show the server's counters");
  return {{scenes, &list_scenes_of}, {sessions, &list_sessions},
          {reloading, &reload},      {evicting, &evict},
          {setting, &set},           {recording, &record},
          {keeping, &recordings},    {counting, &show_counters}};
}

void run(const std::vector<AdminCommand>& commands, const ServerAccess& server,
         const AdminWords& words, const Write& write) {
  for (const AdminCommand& command : commands)
    if (command.command->parsed()) command.run(server, words, write);
}

int fail(const std::string& why, int status) {
  std::fprintf(stderr, "feltwire-client admin: %s\n", printable_error(why).c_str());
  return status;
}

}  // namespace

int admin_command(int argc, char** argv) {
  CLI::App app("Shows and changes the state of a running server", "feltwire-client admin");
  app.footer(kExamples);
  app.require_subcommand(1);
  AdminWords words;
  const CommandLine line(argv, static_cast<std::size_t>(argc));
  const std::vector<AdminCommand> commands = add_commands(app, words, line);
  const auto print = [](std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
  };
  try {
    parse_arguments(app, argc, argv);
    run(commands, {parse_endpoint(words.connect), credentials(words.credentials)}, words, print);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    return fail(error.what() + advice(error, app) + "; see --help", kBadUsage);
  } catch (const std::invalid_argument& error) {
    return fail(error.what(), kBadUsage);
  } catch (const std::exception& error) {
    return fail(error.what(), kCannotRun);
  }
}

std::string admin_answer(const ServerAccess& server, const std::vector<std::string>& words) {
  CLI::App app("", "admin");
  app.require_subcommand(1);
  AdminWords read;
  const std::vector<AdminCommand> commands = add_commands(app, read, {});
  try {
    refuse_missing_values(app, words);
    refuse_misread_values(app);
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::ParseError& error) {
    throw std::invalid_argument(error.get_exit_code() == 0
                                    ? "--help is for feltwire-client only"
                                    : without_tokens(error.what() + advice(error, app)));
  }
  read.json = true;
  std::string text;
  run(commands, server, read, [&](std::string_view piece) { text += piece; });
  return text;
}

}  // namespace feltwire
