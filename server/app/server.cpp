#include "server/app/server.hpp"

#include <spdlog/spdlog.h>

#include <asio/executor_work_guard.hpp>
#include <asio/post.hpp>
#include <future>
#include <stdexcept>
#include <thread>

#include "core/base/file_error.hpp"
#include "core/base/visible_text.hpp"
#include "protocol/net/post.hpp"
#include "server/access/admin_token.hpp"
#include "server/app/fleet_settings.hpp"
#include "server/app/page_address.hpp"
#include "server/app/part_options.hpp"
#include "server/app/prometheus_metrics.hpp"
#include "server/app/server_fleet.hpp"
#include "server/control/control_service.hpp"
#include "server/recording/recorder.hpp"
#include "server/scene/scene_ports.hpp"
#include "server/web/web_server.hpp"

namespace feltwire {

using control::RefusalCode;
using control::Refused;
namespace {

std::vector<Scene> load_scenes(const ServerConfig& config) {
  validate(config);
  std::vector<Scene> scenes;
  for (const auto& file : config.scenes) scenes.push_back(loader_of(config)(file));
  return scenes;
}

/// Loads the certificate and the tokens, also those of the fleet. If there is a live page, adds a
/// token for the link that opens it as an admin on this machine.
Security security_of(const ServerConfig& config) {
  Security security = open_security(config);
  if (!config.web.empty() && config.tokens.empty()) try {
      make_admin_token(config);
    } catch (const FileError& error) {
      spdlog::warn("there is no link to the page for an admin: {}", visible(error.what()));
    }
  security.tokens = TokenFile(token_file(config), fleet_token_file(config));
  return security;
}

}  // namespace

void check_scene_names(const std::vector<Scene>& scenes) {
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::string& name = scenes[i].name();
    if (name.size() > control::kMaxName)
      throw std::invalid_argument("scene '" + name + "': its name is longer than the protocol's " +
                                  std::to_string(control::kMaxName) + " bytes; shorten it");
    for (std::size_t j = 0; j < i; ++j)
      if (scenes[j].name() == name)
        throw std::invalid_argument("two scenes are named '" + name +
                                    "'; clients join by name, so rename one");
  }
}

struct Server::Parts {
  asio::io_context io{1};
  Fingerprint fingerprint;
  std::unique_ptr<Recorder> recorder;  // null: nothing is recorded
  SceneHosts hosts;
  ControlService service;
  std::unique_ptr<ControlEndpoint> control;
  std::unique_ptr<web::PageHands> page_hands;  // null: viewers cannot hold a hand
  std::unique_ptr<web::WebServer> web;         // null: there is no live page
  std::unique_ptr<web::WebServer> metrics;     // null: there is no port for the counters alone
  std::unique_ptr<ServerFleet> fleet;          // null: the server is in no fleet
  const SecurityOptions security_files;
  std::string certificate, client_authorities;  // in use, PEM
  asio::steady_timer look{io};
  bool looking = false;                            // true: the timer `look` runs
  const std::vector<std::filesystem::path> files;  // scene files; empty: the caller passed scenes
  SceneLoader loader;
  std::thread thread;

  Parts(const ServerConfig& config, std::vector<Scene> scenes, Security security,
        SceneLoader::Load load, const web::MakePageHands& hands)
      : fingerprint(feltwire::fingerprint(security.identity)),
        service(io, hosts, security.tokens, service_limits(config),
                {.reload = [this](std::size_t host,
                                  AdminService::Reloaded done) { reload(host, std::move(done)); },
                 .connections = [this] { return control->counters(); },
                 .write_flight = flight_writer(config),
                 .record = recording_actor(config)}),
        security_files(config),
        certificate(security.identity.certificate),
        client_authorities(security.client_authorities),
        files(config.scenes),
        loader(scenes.size(), std::move(load)) {
    check_scene_names(scenes);
    auto sockets = listen(config, security, scenes.size());
    SceneHostOptions options = host_options(config);
    options.ended = [this](std::vector<EndedSession> sessions) {
      asio::post(io, [this, sessions = std::move(sessions)] { service.forget(sessions); });
    };
    warn_of_spinning(options.busy_poll, scenes.size());
    if (const RecorderOptions recorded = recorder_options(config); recorded.any())
      recorder = std::make_unique<Recorder>(recorded, scenes);
    std::vector<LoadedFleetScene> loaded = fleet_scenes(config, scenes);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      options.socket = sockets[i].release();
      if (recorder != nullptr) options.events = &recorder->log(i);
      hosts.push_back(std::make_unique<SceneHost>(std::move(scenes[i]), options));
      if (recorder != nullptr) recorder->see(i, hosts[i]->recorded_pictures(), hosts[i].get());
    }
    if (!config.metrics.empty()) open_metrics(config, security);
    if (!config.web.empty()) open_page(config, std::move(security), hands);
    if (!config.fleet.empty()) open_fleet(config, std::move(loaded));
    // Start the threads only now, because all ports are bound.
    for (auto& host : hosts) host->start();
    if (recorder != nullptr) recorder->start();
    if (fleet != nullptr) fleet->start();
    control->start();
    if (web != nullptr) web->start();
    if (metrics != nullptr) metrics->start();
    look_after();
    thread = std::thread([this] { run(); });
  }

  ~Parts() { stop(); }

  /// Connects to the directory of the fleet.
  void open_fleet(const ServerConfig& config, std::vector<LoadedFleetScene> loaded) {
    const auto lost = [this](const std::vector<std::string>& names) {
      asio::post(io, [this, names] { service.end_sessions(names); });
    };
    const auto tokens = [this] { asio::post(io, [this] { service.look_after(); }); };
    fleet = std::make_unique<ServerFleet>(
        config,
        ServerFleet::Host{control->port(), fingerprint, hosts, std::move(loaded), lost, tokens});
    service.join_fleet(fleet->member());
  }

  /// Opens the live page. If clients must show a certificate, viewers cannot hold a hand, because
  /// the page's hands have no certificate.
  void open_page(const ServerConfig& config, Security security, const web::MakePageHands& hands) {
    web::WebOptions page = page_place(config.web, config.web_names);
    if (hands && config.web_hands > 0 && security.client_authorities.empty())
      page_hands = hands({own_host(config.address), control->port(), fingerprint,
                          static_cast<std::size_t>(config.web_hands)});
    page.hands = page_hands.get();
    page.metrics = [this](const web::ViewerHubCounters& counters) {
      return metrics_text(summary(), control_summary(), counters);
    };
    page.reload = [this](std::size_t host) {
      asio::post(io, [this, host] {
        reload(host, [](const std::optional<Refused>&) {});  // reload() informs the page itself
      });
    };
    page.write_flight = flight_writer(config);
    page.record = recording_actor(config);
    std::vector<SceneInView*> scenes;
    for (const auto& host : hosts) scenes.push_back(host.get());
    web = std::make_unique<web::WebServer>(page, scenes, std::move(security.tokens),
                                           security.identity);
  }

  /// Opens the port for the counters alone.
  void open_metrics(const ServerConfig& config, const Security& security) {
    web::WebOptions options = page_place(config.metrics, config.web_names);
    options.counters_only = true;
    options.metrics = [this](const web::ViewerHubCounters& none) {
      // The viewers are those of the page. This port stops before it.
      return metrics_text(summary(), control_summary(),
                          web != nullptr ? web->counters_now() : none);
    };
    metrics = std::make_unique<web::WebServer>(options, web::ViewerHub::Scenes{}, security.tokens,
                                               security.identity);
  }

  /// Changes the certificate of new connections, and the authorities of their clients.
  void renew_certificate() {
    const RenewedFiles renewed = read_security_again(security_files);
    const Identity& identity = renewed.identity;
    const bool has_others =
        std::exchange(client_authorities, renewed.client_authorities) != renewed.client_authorities;
    const bool is_new = std::exchange(certificate, identity.certificate) != identity.certificate;
    if (has_others) spdlog::info("the authorities of the clients are renewed");
    if (has_others || is_new)
      asio::post(io,
                 [this, renewed] { control->renew(renewed.identity, renewed.client_authorities); });
    if (!is_new) return;
    const Fingerprint print = feltwire::fingerprint(identity);
    spdlog::info("the certificate is renewed; its fingerprint is {}", to_string(print));
    if (page_hands != nullptr) page_hands->trust(print);
    if (web != nullptr) web->renew(identity);
    if (metrics != nullptr) metrics->renew(identity);
  }

  /// Returns a function for another thread that calls `done` on the control thread. `done` may own
  /// a connection, which must be destroyed there.
  template <class Outcome>
  std::function<void(Outcome)> on_control_thread(std::function<void(Outcome)> done) {
    auto asked = std::make_shared<std::function<void(Outcome)>>(std::move(done));
    return [this, asked = std::move(asked)](Outcome outcome) {
      post_patiently(post_to(io), [asked, outcome = std::move(outcome)] {
        const auto tell = std::exchange(*asked, {});
        tell(outcome);
      });
    };
  }

  /// Returns the function that writes a flight record. Empty if there is no flight recorder.
  AdminService::WriteFlight flight_writer(const ServerConfig& config) {
    if (config.recording.flight_folder.empty()) return {};
    return [this](std::size_t scene, AdminService::FlightWritten done) {
      recorder->ask_for_flight_record(
          scene,
          on_control_thread<std::optional<std::filesystem::path>>(
              [done = std::move(done)](const std::optional<std::filesystem::path>& file) {
                if (file) return done(file->string());
                done(Refused{RefusalCode::failed,
                             "the flight record could not be written; the server's log says why"});
              }));
    };
  }

  /// Returns the function that starts and stops recordings. Empty if there is no folder for them.
  AdminService::Record recording_actor(const ServerConfig& config) {
    if (config.recording.folder.empty()) return {};
    return [this](std::size_t scene, control::RecordingAction action, AdminService::Recorded done) {
      recorder->record(scene, action, on_control_thread(std::move(done)));
    };
  }

  std::vector<SceneSummary> summary() {
    std::vector<SceneSummary> result;
    for (const auto& host : hosts) result.push_back(host->summary());
    return result;
  }

  ControlSummary control_summary() {
    const auto count = [this] { return ControlSummary{control->counters(), service.counters()}; };
    if (!thread.joinable()) return count();
    std::promise<ControlSummary> counted;  // only the control thread may read the counters
    asio::post(io, [&] { counted.set_value(count()); });
    return counted.get_future().get();
  }

  /// Binds the control port (TCP), and the port of the scenes (UDP) directly after it. Returns the
  /// sockets of the scenes.
  std::vector<asio::ip::udp::socket> listen(const ServerConfig& config, const Security& security,
                                            std::size_t scenes) {
    ControlOptions options = control_options(config);
    return listen_with_room(static_cast<std::uint16_t>(config.port), [&](std::uint16_t port) {
      options.port = port;
      control = std::make_unique<ControlEndpoint>(
          io, options, security.identity, security.client_authorities,
          [this](ControlPeer& peer, control::Message request, ControlAnswer answer) {
            service.handle(peer, std::move(request), std::move(answer));
          });
      return open_scene_sockets(io, options.address, control->port() + 1u, scenes);
    });
  }

  /// Runs the control thread. A connection's handlers catch their own exceptions. An exception of
  /// another handler is logged, and all connections continue.
  void run() {
    // Pause after an exception, against a busy loop of exceptions.
    constexpr std::chrono::milliseconds kPause{100};
    for (bool ended = false; !ended;) {
      try {
        control->end_lost();
        control->keep_accepting();
        if (!looking) look_after();
        io.run();
        ended = true;
      } catch (const std::exception& error) {
        spdlog::error("control: {}; it goes on", error.what());
        std::this_thread::sleep_for(kPause);
      }
    }
  }

  void look_after() {
    look.expires_after(std::chrono::seconds(1));
    look.async_wait([this](const std::error_code& cancelled) {
      looking = false;
      if (cancelled) return;
      look_after();
      control->end_lost();
      loader.tell();
      service.look_after();
    });
    looking = true;
  }

  /// Loads a scene's file again in another thread. Then reports the result to the live page and
  /// calls `asked`, both on the control thread. Call reload() on the control thread.
  void reload(std::size_t host, AdminService::Reloaded asked) {
    const auto done = [this, host, asked = std::move(asked)](std::optional<Refused> refused) {
      if (web != nullptr) web->tell(host, refused ? std::optional(refused->reason) : std::nullopt);
      asked(std::move(refused));
    };
    if (files.size() != hosts.size())
      return done(
          Refused{RefusalCode::bad_scene,
                  "the scenes of this server do not come from files, so they cannot be reloaded"});
    struct Ended {
      AdminService::Reloaded done;
      LoadedScene loaded;
    };
    const auto ended = std::make_shared<Ended>(Ended{done, std::string()});
    const auto pass_on = [this, host, ended](LoadedScene loaded) {
      ended->loaded = std::move(loaded);
      post_patiently(post_to(io),
                     [this, host, ended] { ended->done(enter(host, std::move(ended->loaded))); });
    };
    if (!loader.begin(host, files[host], pass_on))
      ended->done(Refused{RefusalCode::too_many,
                          "scene '" + hosts[host]->name() +
                              "' is being loaded already; wait until that has ended"});
  }

  /// Replaces the scene of `host` by the loaded scene. Returns a refusal if the load has failed or
  /// the name of the scene has changed.
  std::optional<Refused> enter(std::size_t host, LoadedScene loaded) {
    if (auto* wrong = std::get_if<std::string>(&loaded))
      return Refused{RefusalCode::bad_scene, std::move(*wrong)};
    auto& scene = std::get<Scene>(loaded);
    if (scene.name() != hosts[host]->name())
      return Refused{RefusalCode::bad_scene, files[host].string() + ": name: is '" + scene.name() +
                                                 "' now, and clients know '" + hosts[host]->name() +
                                                 "'; keep the name"};
    hosts[host]->reload(std::move(scene));
    spdlog::info("scene {} was reloaded", hosts[host]->name());
    return std::nullopt;
  }

  /// Reloads all scenes. Calls `done` with the errors when the last reload has ended.
  void reload(std::function<void(std::vector<std::string>)> done) {
    struct All {
      std::size_t left;
      std::vector<std::string> wrong;
      std::function<void(std::vector<std::string>)> done;
    };
    const auto all = std::make_shared<All>(All{hosts.size(), {}, std::move(done)});
    for (std::size_t i = 0; i < hosts.size(); ++i)
      reload(i, [all](const std::optional<Refused>& refused) {
        if (refused) all->wrong.push_back(refused->reason);
        if (--all->left == 0 && all->done) all->done(std::move(all->wrong));
      });
  }

  bool stop() {
    if (fleet != nullptr) fleet->stop();
    if (metrics != nullptr) metrics->stop();
    if (web != nullptr) web->stop();  // before the hosts, because the page uses them
    page_hands.reset();               // ends their sessions
    if (thread.joinable()) {
      asio::post(io, [this] { control->close(); });
      for (auto& host : hosts) host->stop();
      if (recorder != nullptr) recorder->stop();
      // Post this last: the hosts have already posted the sessions that have ended.
      asio::post(io, [this] { io.stop(); });
      thread.join();
    }
    return loader.stop();
  }
};

Server::Server(const ServerConfig& config, const web::MakePageHands& hands)
    : Server(config, load_scenes(config), security_of(config), loader_of(config), hands) {}
Server::Server(const ServerConfig& config, std::vector<Scene> scenes, Security security,
               SceneLoader::Load load, const web::MakePageHands& hands)
    : parts_(std::make_unique<Parts>(config, std::move(scenes), std::move(security),
                                     std::move(load), hands)) {}
Server::~Server() = default;
Server::Server(Server&&) noexcept = default;
Server& Server::operator=(Server&&) noexcept = default;

std::uint16_t Server::control_port() const { return parts_->control->port(); }

std::string Server::web_url() const {
  return parts_->web != nullptr ? parts_->web->url() : std::string();
}

std::string Server::metrics_url() const {
  return parts_->metrics != nullptr ? parts_->metrics->url() + "metrics" : std::string();
}

const Fingerprint& Server::fingerprint() const { return parts_->fingerprint; }

std::vector<Server::ScenePort> Server::scenes() const {
  std::vector<ScenePort> result;
  for (const auto& host : parts_->hosts) result.push_back({host->name(), host->port()});
  return result;
}

void Server::reload(std::function<void(std::vector<std::string>)> done) {
  asio::post(parts_->io, [parts = parts_.get(), done = std::move(done)]() mutable {
    parts->reload(std::move(done));
  });
}

void Server::renew_certificate() { parts_->renew_certificate(); }

void Server::write_flight_records() {
  if (parts_->recorder != nullptr) parts_->recorder->ask_for_flight_records();
}

void Server::leave_fleet() {
  if (parts_->fleet != nullptr) parts_->fleet->leave();
}

bool Server::stop() { return parts_->stop(); }

std::vector<SceneSummary> Server::summary() const { return parts_->summary(); }

ControlSummary Server::control_summary() const { return parts_->control_summary(); }

}  // namespace feltwire
