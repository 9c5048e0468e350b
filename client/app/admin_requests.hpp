#pragma once
// The requests of `feltwire-client admin` to a server, and the texts of their answers.

#include <optional>
#include <string>
#include <vector>

#include "client/run/run_client.hpp"
#include "client/transport/control_client.hpp"

namespace feltwire {

/// Changes of a session's parameters. What is not given stays.
struct SessionWords {
  std::optional<std::string> mode, projection, storage, reference;
  std::optional<double> operator_damping;            // [N s/m]
  std::optional<double> velocity_cutoff;             // [Hz]
  std::optional<double> c1, c2, coupling_stiffness;  // [N/m]
  std::optional<double> coupling_damping;            // [N s/m]
  std::optional<double> tool_mass;                   // [kg]
  friend bool operator==(const SessionWords&, const SessionWords&) = default;
};

/// The parameters with the changes made. Throws std::invalid_argument naming the choices where a
/// name is none.
SessionParameters changed(SessionParameters parameters, const SessionWords& words);

/// A session with the scene that it is in.
struct SeenSession {
  std::string scene;
  control::SessionDescription session;
};

/// Those of one scene, or of all that the token opens where `scene` is empty. Blocks and throws as
/// join() does.
std::vector<SeenSession> sessions_of(const ServerAccess& server, const std::string& scene);

/// The session that a user names: by its number, where `scene` is given or there is no other of
/// that number, or by its id. Throws std::invalid_argument with the remedy where it is none.
const SeenSession& session_named(const std::vector<SeenSession>& sessions, const std::string& name);

/// The scene of that name, or the only one where it is empty. Throws std::invalid_argument that
/// names those there are.
std::string scene_named(const ServerAccess& server, const std::string& name);

/// Counters of the control port (its scene is empty) and of each scene.
struct SeenCounters {
  std::string scene;
  std::vector<control::Counter> counters;
};
std::vector<SeenCounters> counters_of(const ServerAccess& server);

/// One line a session under a heading; "-": not known.
std::string session_table(const std::vector<SeenSession>& sessions);
/// JSON with a line break at the end. Values that are not known are null.
std::string session_json(const std::vector<SeenSession>& sessions);
std::string counter_lines(const std::vector<SeenCounters>& counters);
std::string counter_json(const std::vector<SeenCounters>& counters);

/// Asks, and returns the answer, which is an `Answer`. Throws SessionError where it is another.
template <class Answer>
Answer ask_for(const ServerAccess& server, const control::Message& request) {
  control::Message answer = ask(server, request, kControlTimeout);
  if (auto* good = std::get_if<Answer>(&answer)) return std::move(*good);
  throw SessionError(to_string(server.endpoint) +
                     " gave another answer than was asked for; is it of this version?");
}

}  // namespace feltwire
