#pragma once
// The whole server as a value: programs and tests start it alike.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "server/access/security.hpp"
#include "server/app/config.hpp"
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

class Server {
 public:
  /// Loads the scenes, the certificate and the tokens of the configuration, binds every port and
  /// starts the threads. Throws FileError, std::invalid_argument or std::runtime_error, each one
  /// clear line. `hands` makes the hands that viewers of the live page may hold
  /// (server/app/page_hands.hpp); empty: none.
  explicit Server(const ServerConfig& config, const web::MakePageHands& hands = {});
  /// The same with these at hand; the configuration's own are not read.
  /// `load` reads a scene's file anew at a reload.
  Server(const ServerConfig& config, std::vector<Scene> scenes, Security security,
         SceneLoader::Load load = load_scene_and_warn, const web::MakePageHands& hands = {});
  /// Stops.
  ~Server();
  Server(Server&&) noexcept;
  Server& operator=(Server&&) noexcept;

  std::uint16_t control_port() const;
  /// The certificate's fingerprint, which clients pin.
  const Fingerprint& fingerprint() const;

  struct ScenePort {
    std::string scene;
    std::uint16_t udp_port = 0;
  };
  std::vector<ScenePort> scenes() const;

  /// The live page, "http://127.0.0.1:6760/"; empty where none is served.
  std::string web_url() const;

  /// Reads the scenes' files anew, beside what the server does; clients go on in them. Returns at
  /// once. `done` is called on the control thread when all are read: what is wrong, one line a file
  /// whose scene stays as it was. It is not called where the server stops before that.
  void reload(std::function<void(std::vector<std::string> wrong)> done = {});

  /// Has the last ten seconds of each scene be written to the folder for flight records, if there
  /// is one. Returns at once.
  void write_flight_records();

  /// Ends connections, says goodbye to every client, cancels what is loaded and joins all threads.
  /// False where a thread had to be left behind that reads a scene's file and gets no answer: then
  /// the process should end with std::_Exit. May be called again.
  bool stop();

  /// One entry a scene, up to now. Not while another thread stops the server.
  std::vector<SceneSummary> summary() const;
  /// The control service's totals. Precondition: as for summary().
  ControlSummary control_summary() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// A summary as people read it.
std::string text(const std::vector<SceneSummary>& summary);
std::string text(const ControlSummary& summary);

}  // namespace feltwire
