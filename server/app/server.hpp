#pragma once
// The whole server as a value; programs and tests start it in the same way.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "server/access/security.hpp"
#include "server/app/server_config.hpp"
#include "server/control/control_service.hpp"
#include "server/scene/scene_host.hpp"
#include "server/scene/scene_loader.hpp"
#include "server/web/page_hands.hpp"

namespace feltwire {

/// Counts of the control port, for the summary.
struct ControlSummary {
  ControlCounters connections;
  ServiceCounters requests;
};

/// Throws std::invalid_argument if a name is longer than control::kMaxName, or two are equal.
void check_scene_names(const std::vector<Scene>& scenes);

class Server {
 public:
  /// Loads the scenes, the certificate and the tokens of the configuration, binds every port and
  /// starts the threads. Throws FileError, std::invalid_argument or std::runtime_error, each with
  /// one clear line. `hands` makes the hands for viewers of the live page
  /// (gateway/page_hand/make_page_hands.hpp); empty: none.
  explicit Server(const ServerConfig& config, const web::MakePageHands& hands = {});
  /// Uses the given scenes and identity; those of the configuration are not read. `load` reads
  /// a scene's file again at a reload.
  Server(const ServerConfig& config, std::vector<Scene> scenes, Security security,
         SceneLoader::Load load = load_scene_and_warn, const web::MakePageHands& hands = {});
  /// Stops the server.
  ~Server();
  Server(Server&&) noexcept;
  Server& operator=(Server&&) noexcept;

  std::uint16_t control_port() const;
  /// The fingerprint of the certificate at the start, which clients pin.
  const Fingerprint& fingerprint() const;

  struct ScenePort {
    std::string scene;
    std::uint16_t udp_port = 0;
  };
  std::vector<ScenePort> scenes() const;

  /// The live page, "http://127.0.0.1:6760/"; empty if there is none.
  std::string web_url() const;
  /// The counters for Prometheus, "http://127.0.0.1:6762/metrics"; empty if there is no such port.
  std::string metrics_url() const;

  /// Reads the scenes' files again while the server runs; clients continue in the new scenes.
  /// Returns at once. `done` is called on the control thread when all are read, with the errors,
  /// one line for each file whose scene stays unchanged. It is not called if the server stops
  /// before that.
  void reload(std::function<void(std::vector<std::string> wrong)> done = {});

  /// Reads the certificate and its key again. If they have changed, new connections get them;
  /// those that exist go on. Throws FileError, and nothing changes.
  void renew_certificate();

  /// Requests a flight record of each scene (the last ten seconds), if there is a folder for them.
  /// Returns at once.
  void write_flight_records();

  /// Hands the scenes over to other hosts of the fleet, so that their hands go there at once.
  /// Blocks for some seconds at most; without a fleet it does nothing.
  void leave_fleet();

  /// Ends connections, says goodbye to every client, cancels loads and joins all threads. False if
  /// it had to leave a thread behind that reads a scene's file and gets no answer: then the process
  /// should end with std::_Exit. May be called again.
  bool stop();

  /// The summaries up to now, one for each scene. Do not call it while another thread stops the
  /// server.
  std::vector<SceneSummary> summary() const;
  /// The control service's totals. Precondition: as for summary().
  ControlSummary control_summary() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The summary as text for people.
std::string text(const std::vector<SceneSummary>& summary);
std::string text(const ControlSummary& summary);

}  // namespace feltwire
