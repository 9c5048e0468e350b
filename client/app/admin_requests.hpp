#pragma once
// The requests of `feltwire-client admin` to a server, and the texts of their answers.

#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "client/run/run_client.hpp"
#include "client/transport/control_client.hpp"

namespace feltwire {

/// A session and its scene.
struct SeenSession {
  std::string scene;
  control::SessionDescription session;
};
using SeenSessions = std::deque<SeenSession>;

/// The sessions of one scene, or of all that the token opens if `scene` is empty. Blocks and throws
/// as join() does.
SeenSessions sessions_of(const ServerAccess& server, const std::string& scene);

/// Finds the session that a user names: by its number, if `scene` is given or the number is unique,
/// or by its id. Throws std::invalid_argument with the remedy if there is none.
const SeenSession& session_named(const SeenSessions& sessions, const std::string& name);

/// The scene with that name, or the only one if it is empty. Throws std::invalid_argument that
/// lists the existing ones.
std::string scene_named(const ServerAccess& server, const std::string& name);
/// The scene with that name, or all that the token opens if it is empty.
std::vector<std::string> scenes_named(const ServerAccess& server, const std::string& name);

/// Counters of the control port (its scene is empty) and of each scene. Throws FalseAnswer if a
/// server tells so many that they have no room.
struct SeenCounters {
  std::string scene;
  std::vector<control::Counter> counters;
};
std::vector<SeenCounters> counters_of(const ServerAccess& server);

/// A line for each scene under a heading.
std::string scene_table(const Endpoint& server, const std::vector<control::SceneEntry>& scenes);
std::string scene_json(const Endpoint& server, const std::vector<control::SceneEntry>& scenes);
/// A line for each session under a heading; "-": not known.
std::string session_table(const SeenSessions& sessions);
/// JSON with a line break at the end, in pieces: its whole text would take as much memory as the
/// sessions. Values that are not known are null.
void write_session_json(const SeenSessions& sessions,
                        const std::function<void(std::string_view piece)>& write);
std::string counter_lines(const std::vector<SeenCounters>& counters);
std::string counter_json(const std::vector<SeenCounters>& counters);

/// The recordings of a scene at the server: a line for the one that runs or ran last, and a line
/// for each complete file.
std::string recordings_lines(const control::SceneRecordings& recordings);
/// These recordings as a JSON object, without a line break at its end.
std::string recordings_json(const control::SceneRecordings& recordings);

/// The values of an answer, each with its name.
using AnswerFields = std::vector<std::pair<std::string, std::variant<std::string, std::uint32_t>>>;
/// The scene, the number and the id of a session.
AnswerFields fields_of(const SeenSession& seen);
/// "session 3 of scene room"
std::string text_of(const SeenSession& seen);
/// The values as a JSON object, without a line break at its end.
std::string answer_json(const AnswerFields& fields);
/// JSON texts as an array, with a line break at its end.
std::string json_list(const std::vector<std::string>& values);

/// Sends a request, and returns its answer of type `Answer`. Throws SessionError if it is another.
template <class Answer>
Answer ask_for(const ServerAccess& server, const control::Message& request) {
  control::Message answer = ask(server, request, kControlTimeout);
  if (auto* good = std::get_if<Answer>(&answer)) return std::move(*good);
  throw SessionError(to_string(server.endpoint) +
                     " gave another answer than was asked for; is it of this version?");
}

}  // namespace feltwire
