#include "server/control/admin_service.hpp"

#include <spdlog/spdlog.h>

#include "core/base/visible_text.hpp"
#include "protocol/net/post.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

using control::RefusalCode;
using control::Refused;
namespace {

/// Makes the answer to DescribeScene: the materials of the objects from index `from` on, as many as
/// one message may hold. `times`: counted by the scene's thread.
control::SceneDescription described(const SceneInView::CurrentScene& current, std::uint32_t from,
                                    const control::SceneTimes& times) {
  const std::vector<Object>& objects = current.scene->objects();
  control::SceneDescription description{current.version,
                                        current.changes,
                                        current.gravity,
                                        static_cast<std::uint32_t>(objects.size()),
                                        {},
                                        times};
  for (std::size_t i = from; i < objects.size(); ++i) {
    if (description.materials.size() == control::kMaxMaterials) break;
    description.materials.push_back(objects[i].material);
  }
  return description;
}

Refused no_flight_recorder() {
  return {RefusalCode::not_supported,
          "this server keeps no flight record; start it with --flight-recorder DIR"};
}

Refused no_recordings() {
  return {RefusalCode::not_supported,
          "admins start no recordings at this server; start it with --recordings DIR"};
}

}  // namespace

AdminService::AdminService(asio::io_context& io, SceneHosts& hosts, SessionDirectory& directory,
                           RequestLimits& limits, Callbacks callbacks)
    : io_(io),
      hosts_(hosts),
      directory_(directory),
      limits_(limits),
      callbacks_(std::move(callbacks)),
      shape_parts_(io) {}

void AdminService::look_after() {
  for (std::size_t scene = 0; scene < hosts_.size(); ++scene)
    shape_parts_.forget_others(scene, hosts_[scene]->current_scene().version);
}

/// Answers DescribeSessions and DescribeScene, the requests of observers. Returns false for any
/// other request.
bool AdminService::describe(PendingRequest& asked, const control::Message& request) {
  const auto* sessions = std::get_if<control::DescribeSessions>(&request);
  const auto* wanted = std::get_if<control::DescribeScene>(&request);
  if (sessions == nullptr && wanted == nullptr) return false;
  const auto scene =
      scene_for(asked.token, sessions != nullptr ? sessions->scene : wanted->scene, Role::observer);
  if (const auto* refused = std::get_if<Refused>(&scene)) {
    asked.answer(*refused);
  } else if (auto hasty = limits_.check_questions(asked.token)) {
    asked.answer(*std::move(hasty));
  } else if (wanted != nullptr) {
    SceneHost& host = *hosts_[std::get<std::size_t>(scene)];
    host.ask(request, 0, {}, io_,
             [current = host.current_scene(), from = wanted->from,
              answer = std::move(asked.answer)](control::Message told) {
               if (const auto* counted = std::get_if<control::SceneDescription>(&told))
                 told = described(current, from, counted->times);
               answer(std::move(told));
             });
  } else {
    hosts_[std::get<std::size_t>(scene)]->ask(request, 0, {}, io_, std::move(asked.answer));
  }
  return true;
}

/// Answers DescribeShapes and GetShape, the requests of observers that draw a scene. Returns false
/// for any other request.
bool AdminService::describe_shapes(PendingRequest& asked, const control::Message& request) {
  const auto* list = std::get_if<control::DescribeShapes>(&request);
  const auto* get = std::get_if<control::GetShape>(&request);
  if (list == nullptr && get == nullptr) return false;
  const auto found =
      scene_for(asked.token, list != nullptr ? list->scene : get->scene, Role::observer);
  if (const auto* refused = std::get_if<Refused>(&found)) {
    asked.answer(*refused);
    return true;
  }
  const std::size_t scene = std::get<std::size_t>(found);
  if (get != nullptr) {
    shape_parts_.part(scene, hosts_[scene]->current_scene(), *get, std::move(asked.answer));
  } else if (auto hasty = limits_.check_questions(asked.token)) {
    asked.answer(*std::move(hasty));
  } else {
    asked.answer(described_shapes(hosts_[scene]->current_scene(), *list));
  }
  return true;
}

bool AdminService::handle(PendingRequest& asked, const control::Message& request) {
  if (describe(asked, request) || describe_shapes(asked, request)) return true;
  if (const auto* eviction = std::get_if<control::Evict>(&request)) {
    asked.answer(evict(asked.token, *eviction));
    return true;
  }
  if (const auto* list = std::get_if<control::ListSessions>(&request)) {
    asked.answer(list_sessions(asked.token, *list));
    return true;
  }
  if (const auto* anew = std::get_if<control::ReloadScene>(&request)) {
    reload(std::move(asked), *anew);
    return true;
  }
  if (const auto* material = std::get_if<control::SetMaterial>(&request)) {
    change(std::move(asked), material->scene, material->change);
    return true;
  }
  if (const auto* gravity = std::get_if<control::SetGravity>(&request)) {
    change(std::move(asked), gravity->scene, GravityChange{gravity->gravity});
    return true;
  }
  if (const auto* link = std::get_if<control::SetLink>(&request)) {
    change_session(std::move(asked), link->session, LinkChange{link->session, link->link});
    return true;
  }
  if (const auto* lead = std::get_if<control::SetLead>(&request)) {
    change_session(std::move(asked), lead->session, LeadChange{lead->session, lead->share});
    return true;
  }
  if (const auto* flight = std::get_if<control::WriteFlightRecord>(&request)) {
    write_flight(std::move(asked), *flight);
    return true;
  }
  if (const auto* recording = std::get_if<control::RecordScene>(&request)) {
    record(std::move(asked), *recording);
    return true;
  }
  if (const auto* counters = std::get_if<control::GetCounters>(&request)) {
    count(std::move(asked), *counters);
    return true;
  }
  return false;
}

/// Returns the index of the scene with this name if the token opens the scene and has at least this
/// role. Otherwise returns the refusal.
std::variant<std::size_t, Refused> AdminService::scene_for(const Token& token,
                                                           const std::string& name, Role role) {
  if (auto refused = limits_.check_role(role, token)) return *std::move(refused);
  const std::size_t scene = index_of_scene(hosts_, name);
  if (scene == hosts_.size() || !opens(token, name)) return unknown_scene(name);
  return scene;
}

control::Message AdminService::evict(const Token& token, const control::Evict& request) {
  if (auto refused = limits_.check_role(Role::admin, token)) return *std::move(refused);
  // An admin must not learn of sessions in scenes that the token does not open.
  const ListedSession* session = directory_.find_open(token, request.session);
  if (session == nullptr) return unknown_session(request.session);
  hosts_[session->scene]->evict(request.session);
  spdlog::info("a session of client {} was evicted by client {}", visible(session->client),
               visible(token.client));
  return control::Evicted{request.session};
}

control::Message AdminService::list_sessions(const Token& token,
                                             const control::ListSessions& request) {
  if (auto refused = limits_.check_role(Role::admin, token)) return *std::move(refused);
  return directory_.list(token, request.after);
}

void AdminService::reload(PendingRequest asked, const control::ReloadScene& request) {
  const auto scene = scene_for(asked.token, request.scene, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  if (auto refused = limits_.check_changes(asked.token.client))
    return asked.answer(*std::move(refused));
  spdlog::info("scene {} is reloaded by client {} (token {})", request.scene,
               visible(asked.token.client), asked.token.id);
  asked.peer.waits = true;
  callbacks_.reload(std::get<std::size_t>(scene),
                    [this, name = request.scene,
                     answer = std::move(asked.answer)](std::optional<Refused> refused) {
                      if (!refused) return answer(control::SceneReloaded{name});
                      if (refused->code == RefusalCode::too_many)
                        refused = limits_.refuse(RefusalCode::too_many, std::move(refused->reason));
                      answer(*std::move(refused));
                    });
}

/// Applies a change to a running scene, and then answers the admin's request.
void AdminService::change(PendingRequest asked, const std::string& name, LiveChange change) {
  const auto scene = scene_for(asked.token, name, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  if (auto refused = limits_.check_changes(asked.token.client))
    return asked.answer(*std::move(refused));
  const std::string by =
      visible("client " + asked.token.client + " (token " + asked.token.id + ")");
  hosts_[std::get<std::size_t>(scene)]->change(
      std::move(change), post_to(io_),
      [name, by, answer = std::move(asked.answer)](std::variant<std::string, Refused> outcome) {
        if (auto* refused = std::get_if<Refused>(&outcome)) return answer(std::move(*refused));
        auto& what = std::get<std::string>(outcome);
        spdlog::info("scene {}: changed by {}: {}", visible(name), by, visible(what));
        answer(control::SceneChanged{name, std::move(what)});
      });
}

/// Applies a change to a session, if the token is an admin's and opens the scene of the session.
void AdminService::change_session(PendingRequest asked, std::uint64_t session, LiveChange wanted) {
  if (auto refused = limits_.check_role(Role::admin, asked.token))
    return asked.answer(*std::move(refused));
  const ListedSession* found = directory_.find_open(asked.token, session);
  if (found == nullptr) return asked.answer(unknown_session(session));
  change(std::move(asked), found->scene_name, std::move(wanted));
}

void AdminService::write_flight(PendingRequest asked, const control::WriteFlightRecord& request) {
  const auto scene = scene_for(asked.token, request.scene, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  if (!callbacks_.write_flight) return asked.answer(no_flight_recorder());
  if (auto refused = limits_.check_changes(asked.token.client))
    return asked.answer(*std::move(refused));
  spdlog::info("scene {}: client {} (token {}) asks for a flight record", visible(request.scene),
               visible(asked.token.client), asked.token.id);
  asked.peer.waits = true;
  callbacks_.write_flight(
      std::get<std::size_t>(scene), [name = request.scene, answer = std::move(asked.answer)](
                                        std::variant<std::string, Refused> outcome) {
        if (auto* refused = std::get_if<Refused>(&outcome)) return answer(std::move(*refused));
        answer(control::FlightRecordWritten{name, std::move(std::get<std::string>(outcome))});
      });
}

void AdminService::record(PendingRequest asked, const control::RecordScene& request) {
  const auto scene = scene_for(asked.token, request.scene, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  if (!callbacks_.record) return asked.answer(no_recordings());
  if (request.action != control::RecordingAction::look) {
    if (auto refused = limits_.check_changes(asked.token.client))
      return asked.answer(*std::move(refused));
    spdlog::info("scene {}: client {} (token {}) {} a recording", visible(request.scene),
                 visible(asked.token.client), asked.token.id,
                 request.action == control::RecordingAction::start ? "starts" : "stops");
  }
  asked.peer.waits = true;
  callbacks_.record(
      std::get<std::size_t>(scene), request.action,
      [answer = std::move(asked.answer)](std::variant<control::SceneRecordings, Refused> outcome) {
        std::visit([&](auto& told) { answer(std::move(told)); }, outcome);
      });
}

void AdminService::count(PendingRequest asked, const control::GetCounters& request) {
  if (!request.scene.empty()) {
    const auto scene = scene_for(asked.token, request.scene, Role::admin);
    if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
    return hosts_[std::get<std::size_t>(scene)]->ask(request, 0, {}, io_, std::move(asked.answer));
  }
  if (auto refused = limits_.check_role(Role::admin, asked.token))
    return asked.answer(*std::move(refused));
  const ControlCounters connections =
      callbacks_.connections ? callbacks_.connections() : ControlCounters{};
  control::Counters named;
  for (const auto& [name, value] : named_counters(connections, limits_.counters()))
    named.counters.push_back({std::string(name), value});
  asked.answer(std::move(named));
}

std::vector<std::pair<std::string_view, std::uint64_t>> named_counters(
    const ControlCounters& connections, const ServiceCounters& requests) {
  return {{"connections", connections.accepted},    {"too_often", connections.too_often},
          {"crowded_out", connections.crowded_out}, {"no_tls", connections.failed},
          {"too_slow", connections.too_slow},       {"unauthenticated", requests.unauthenticated},
          {"forbidden", requests.forbidden},        {"too_many", requests.too_many}};
}

}  // namespace feltwire
