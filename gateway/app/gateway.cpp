#include "gateway/app/gateway.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "core/base/visible_text.hpp"
#include "core/scene_file/load_scene.hpp"
#include "gateway/remote_scene/remote_scene.hpp"
#include "server/app/page_address.hpp"
#include "server/app/prometheus_metrics.hpp"
#include "server/app/server_config.hpp"
#include "server/web/web_server.hpp"

namespace feltwire {
namespace {

constexpr std::chrono::milliseconds kAskTime{3000};

std::vector<Scene> load_scenes(const GatewayConfig& config) {
  if (config.scenes.empty())
    throw std::invalid_argument(
        "--scene: none is given; name the files of the server's scenes, because the protocol "
        "carries "
        "no shapes");
  std::vector<Scene> scenes;
  for (const auto& file : config.scenes) scenes.push_back(load_scene(file));
  return scenes;
}

SecurityOptions page_files(const GatewayConfig& config) {
  SecurityOptions options = config;
  options.address = web_place(config.web).address;
  return options;
}

/// Loads the certificate and the tokens of the page, and creates missing ones. A new certificate
/// names the page's address.
Security open_page_security(const GatewayConfig& config) {
  return open_security(page_files(config));
}

std::string names_of(const std::vector<control::SceneEntry>& entries) {
  std::string names;
  for (const control::SceneEntry& entry : entries)
    names += (names.empty() ? "" : ", ") + entry.name;
  return names.empty() ? "none" : names;
}

/// Checks that the server has these scenes. If the server is unreachable, only warns, because the
/// server may start later.
void compare(const ServerAccess& server, const std::vector<Scene>& scenes) {
  std::vector<control::SceneEntry> entries;
  try {
    entries = list_scenes(server, kAskTime);
  } catch (const LastingError&) {
    throw;
  } catch (const SessionError& error) {
    spdlog::warn("{}; the gateway tries to reconnect", visible(error.what()));
    return;
  }
  for (const Scene& scene : scenes) {
    const auto found = std::ranges::find(entries, scene.name(), &control::SceneEntry::name);
    if (found == entries.end())
      throw std::invalid_argument("--scene: the server has no scene '" + scene.name() +
                                  "' that the token opens; it has: " + names_of(entries));
    if (found->objects != scene.objects().size())
      throw std::invalid_argument("--scene: the server's scene '" + scene.name() + "' has " +
                                  std::to_string(found->objects) + " objects, and the file has " +
                                  std::to_string(scene.objects().size()) +
                                  "; give the file that the server has");
  }
}

}  // namespace

struct Gateway::Parts {
  const SecurityOptions security_files;            // of the page
  const std::vector<std::filesystem::path> files;  // scene files; empty if the caller gave scenes
  std::vector<std::unique_ptr<RemoteScene>> scenes;
  std::unique_ptr<web::WebServer> web;

  Parts(const GatewayConfig& config, std::vector<Scene> looks, Security security)
      : security_files(page_files(config)), files(config.scenes) {
    compare(config.server, looks);
    std::vector<SceneInView*> shown;
    // Divide the memory for session lists among the scenes, because a faulty server may list too
    // many sessions of each scene.
    const LookOptions options_of_scene{
        .list_room =
            std::max(kRoomOfServer / std::max<std::size_t>(1, looks.size()), kLeastRoomOfScene)};
    for (Scene& look : looks) {
      scenes.push_back(
          std::make_unique<RemoteScene>(std::move(look), config.server, options_of_scene));
      shown.push_back(scenes.back().get());
    }
    web::WebOptions options = page_place(config.web, config.web_names);
    options.metrics = [this](const web::ViewerHubCounters& page) {
      return metrics_text(page, times());
    };
    web = std::make_unique<web::WebServer>(options, shown, std::move(security.tokens),
                                           security.identity);
    for (const auto& scene : scenes) scene->start();
    web->start();
  }
  ~Parts() { stop(); }

  std::vector<NamedTimes> times() const {
    std::vector<NamedTimes> all;
    all.reserve(scenes.size());
    for (const auto& scene : scenes) all.emplace_back(scene->name(), scene->server_times());
    return all;
  }

  void reload() {
    for (std::size_t i = 0; i < files.size(); ++i) {
      try {
        Scene scene = load_scene(files[i]);
        if (scene.name() != scenes[i]->name())
          throw std::invalid_argument(files[i].string() + ": name: is '" + scene.name() +
                                      "' now, and viewers know '" + scenes[i]->name() +
                                      "'; keep the name");
        scenes[i]->reload(std::move(scene));
        web->tell(i, std::nullopt);
      } catch (const std::exception& error) {
        spdlog::error("{}; the scene stays as it was", visible(error.what()));
      }
    }
    try {
      web->renew(read_security_again(security_files).identity);
    } catch (const std::exception& error) {
      spdlog::error("{}; the certificate stays as it was", visible(error.what()));
    }
  }

  void stop() {
    web->stop();  // Stop the web server first, because it uses the scenes.
    for (const auto& scene : scenes) scene->stop();
  }
};

Gateway::Gateway(const GatewayConfig& config)
    : Gateway(config, load_scenes(config), open_page_security(config)) {}
Gateway::Gateway(const GatewayConfig& config, std::vector<Scene> scenes, Security security)
    : parts_(std::make_unique<Parts>(config, std::move(scenes), std::move(security))) {}
Gateway::~Gateway() = default;
Gateway::Gateway(Gateway&&) noexcept = default;
Gateway& Gateway::operator=(Gateway&&) noexcept = default;

std::string Gateway::web_url() const { return parts_->web->url(); }
void Gateway::reload() { parts_->reload(); }
void Gateway::stop() { parts_->stop(); }

}  // namespace feltwire
