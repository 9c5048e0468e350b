#include "server/server.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/executor_work_guard.hpp>
#include <asio/post.hpp>
#include <cmath>
#include <random>
#include <stdexcept>
#include <thread>

#include "protocol/udp_socket.hpp"
#include "server/control.hpp"

namespace feltwire {
namespace {

std::vector<Scene> load_scenes(const ServerConfig& config) {
  validate(config);
  std::vector<Scene> scenes;
  for (const auto& file : config.scenes) {
    scenes.push_back(load_scene(file));
    for (const std::string& warning : scenes.back().warnings())
      spdlog::warn("{}: {}", file.string(), warning);
  }
  return scenes;
}

void check_names(const std::vector<Scene>& scenes) {
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

/// Nothing but letters that cannot spoil a log line: a client chooses its own name.
std::string printable(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return name;
}

/// Threads that never sleep and have no core each keep one another, and all else, waiting.
void warn_of_spinning(Nanoseconds busy_poll, std::size_t scenes) {
  const unsigned cores = std::thread::hardware_concurrency();
  if (busy_poll == kForever && scenes + 1 > cores)
    spdlog::warn(
        "{} scenes that never sleep (--busy-poll inf) leave no core of {} to anything else; "
        "a bounded busy poll does",
        scenes, cores);
}

}  // namespace

struct Server::Parts {
  asio::io_context io{1};
  std::vector<std::unique_ptr<SceneHost>> hosts;
  std::unique_ptr<ControlEndpoint> control;
  std::random_device random;  // the operating system's
  std::thread thread;

  Parts(const ServerConfig& config, std::vector<Scene> scenes) {
    check_names(scenes);
    const auto address = asio::ip::make_address(config.address);
    const auto port = static_cast<std::uint16_t>(config.port);
    control = std::make_unique<ControlEndpoint>(
        io, ControlOptions{.address = address, .port = port},
        [this](control::Message request, SceneHost::Completion answer) {
          handle(std::move(request), std::move(answer));
        });
    SceneHostOptions options;
    options.address = address;
    options.silence_timeout = from_seconds(config.silence_timeout);
    if (!config.profile.empty()) options.line = &network_profile(config.profile);
    options.dscp = dscp(config.dscp);
    options.max_sessions = static_cast<std::size_t>(config.max_sessions_per_scene);
    options.busy_poll = busy_poll_time(config.busy_poll);
    warn_of_spinning(options.busy_poll, scenes.size());
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      // The ports follow the control port one by one, so that a firewall can open them.
      options.port = static_cast<std::uint16_t>(port == 0 ? 0 : port + 1 + i);
      hosts.push_back(std::make_unique<SceneHost>(std::move(scenes[i]), options));
    }
    // Every port is bound: from here on nothing fails.
    for (auto& host : hosts) host->start();
    control->start();
    thread = std::thread([this] { io.run(); });
  }

  ~Parts() { stop(); }

  void stop() {
    if (!thread.joinable()) return;
    asio::post(io, [this] {
      control->close();
      io.stop();
    });
    thread.join();
    for (auto& host : hosts) host->stop();
  }

  /// 56 random bits; the low byte says which scene the session is in.
  std::uint64_t new_session_id(std::size_t scene) {
    std::uint64_t bits = 0;
    while (bits == 0) bits = (std::uint64_t{random()} << 32 | random()) << 8;
    return bits | scene;
  }
  SceneHost* host_of(std::uint64_t session) {
    const std::size_t scene = session & 0xff;
    return scene < hosts.size() ? hosts[scene].get() : nullptr;
  }

  // On the control thread.
  void handle(control::Message request, SceneHost::Completion answer) {
    if (const auto* join = std::get_if<control::JoinRequest>(&request)) {
      const auto host = std::find_if(hosts.begin(), hosts.end(), [&](const auto& candidate) {
        return candidate->scene().name() == join->scene;
      });
      if (host == hosts.end())
        return answer(control::Refused{control::RefusalCode::unknown_scene,
                                       "there is no scene '" + join->scene +
                                           "' here; list the scenes to see which there are"});
      const std::uint64_t id = new_session_id(static_cast<std::size_t>(host - hosts.begin()));
      const std::string who = printable(join->client + " (" + join->device.name + ")");
      return (*host)->ask(std::move(request), id, io,
                          [udp_port = (*host)->port(), scene = (*host)->scene().name(), who,
                           answer = std::move(answer)](control::Message message) {
                            if (auto* accepted = std::get_if<control::JoinAccepted>(&message)) {
                              accepted->udp_port = udp_port;
                              spdlog::info("{} joined scene {}", who, scene);
                            } else if (const auto* no = std::get_if<control::Refused>(&message)) {
                              spdlog::warn("{} could not join scene {}: {}", who, scene,
                                           printable(no->reason));
                            }
                            answer(std::move(message));
                          });
    }
    if (std::holds_alternative<control::ListScenes>(request)) return answer(list());

    std::uint64_t session = 0;
    if (const auto* leave = std::get_if<control::LeaveRequest>(&request))
      session = leave->session;
    else if (const auto* set = std::get_if<control::SetParameters>(&request))
      session = set->session;
    else
      return answer(control::Refused{control::RefusalCode::malformed,
                                     "this message is an answer, not a request"});
    SceneHost* host = host_of(session);
    if (host == nullptr)
      return answer(control::Refused{control::RefusalCode::unknown_session,
                                     "there is no session " + std::to_string(session) + " here"});
    host->ask(std::move(request), session, io, std::move(answer));
  }

  control::SceneList list() const {
    control::SceneList result;
    for (const auto& host : hosts)
      result.scenes.push_back({host->scene().name(), host->port(),
                               static_cast<std::uint32_t>(host->scene().objects().size()),
                               host->sessions()});
    return result;
  }
};

Server::Server(const ServerConfig& config) : Server(config, load_scenes(config)) {}
Server::Server(const ServerConfig& config, std::vector<Scene> scenes)
    : parts_(std::make_unique<Parts>(config, std::move(scenes))) {}
Server::~Server() = default;
Server::Server(Server&&) noexcept = default;
Server& Server::operator=(Server&&) noexcept = default;

std::uint16_t Server::control_port() const { return parts_->control->port(); }

std::vector<Server::ScenePort> Server::scenes() const {
  std::vector<ScenePort> result;
  for (const auto& host : parts_->hosts) result.push_back({host->scene().name(), host->port()});
  return result;
}

void Server::stop() { parts_->stop(); }

std::vector<SceneSummary> Server::summary() const {
  std::vector<SceneSummary> result;
  for (const auto& host : parts_->hosts) result.push_back(host->summary());
  return result;
}

std::string text(const std::vector<SceneSummary>& summary) {
  std::string lines;
  for (const SceneSummary& scene : summary) {
    const SceneCounters& c = scene.counters;
    lines += fmt::format(
        "scene {}: sessions {} (left {}, silent {}), samples {}, replies {} ({} withheld), gaps {} "
        "({} samples missed), violations {}, unsent {}\n",
        scene.scene, c.sessions_served, c.left, c.silent, c.samples.samples, c.samples.replies,
        c.samples.withheld, c.samples.gaps, c.samples.missed, c.violations, scene.unsent);
    std::string drops;
    for (std::size_t i = 1; i < c.drops.size(); ++i)
      if (c.drops[i] > 0)
        drops += fmt::format(" {} {}", name(static_cast<DropReason>(i)), c.drops[i]);
    lines +=
        fmt::format("  datagrams {}, dropped:{}\n", c.datagrams, drops.empty() ? " none" : drops);
  }
  return lines;
}

}  // namespace feltwire
