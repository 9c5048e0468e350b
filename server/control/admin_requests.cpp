// Answers to admins (evictions, reloads, live changes, counters) and to observers (the state of a
// scene and of its sessions).

#include <spdlog/spdlog.h>

#include "core/base/visible_text.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/post.hpp"
#include "server/control/pending_request.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {

using control::RefusalCode;
using control::Refused;
namespace {

/// Describes a scene to an observer, whose views have no materials: the materials of the objects
/// from `from` on. `times`: of the scene's thread.
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

}  // namespace

/// Answers an observer's request; false if it is another request.
bool ControlService::serve_observer(PendingRequest& asked, const control::Message& request) {
  const auto* sessions = std::get_if<control::DescribeSessions>(&request);
  const auto* wanted = std::get_if<control::DescribeScene>(&request);
  if (sessions == nullptr && wanted == nullptr) return false;
  const auto scene =
      scene_for(asked, sessions != nullptr ? sessions->scene : wanted->scene, Role::observer);
  if (const auto* refused = std::get_if<Refused>(&scene)) {
    asked.answer(*refused);
  } else if (auto hasty = refuse_curious(asked)) {
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

/// Answers an admin's request; false if it is another request.
bool ControlService::serve_admin(PendingRequest& asked, const control::Message& request) {
  if (const auto* eviction = std::get_if<control::Evict>(&request)) {
    asked.answer(evict(asked, *eviction));
    return true;
  }
  if (const auto* list = std::get_if<control::ListSessions>(&request)) {
    asked.answer(list_sessions(asked, *list));
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
  if (const auto* counters = std::get_if<control::GetCounters>(&request)) {
    count(std::move(asked), *counters);
    return true;
  }
  return false;
}

std::optional<Refused> ControlService::refuse_below(Role role, const PendingRequest& asked) {
  if (covers(asked.token.role, role)) return std::nullopt;
  return refuse(RefusalCode::forbidden, "this is for " + std::string(name(role)) +
                                            "s; the token is for " + holder(asked.token.role));
}

/// The scene of that name, if a token of at least that role opens it.
std::variant<std::size_t, Refused> ControlService::scene_for(const PendingRequest& asked,
                                                             const std::string& name, Role role) {
  if (auto refused = refuse_below(role, asked)) return *std::move(refused);
  const std::size_t scene = scene_of(name);
  if (scene == hosts_.size() || !opens(asked.token, name))
    return Refused{RefusalCode::unknown_scene,
                   "there is no scene '" + name + "' here; list the scenes to see which there are"};
  return scene;
}

control::Message ControlService::evict(const PendingRequest& asked, const control::Evict& request) {
  if (auto refused = refuse_below(Role::admin, asked)) return *std::move(refused);
  const auto found = seated_.find(request.session);
  // Hide scenes that this admin's token does not open.
  if (found == seated_.end() || !opens(asked.token, scene_name(found->second)))
    return unknown_session(request.session);
  hosts_[found->second.scene]->evict(request.session);
  spdlog::info("a session of client {} was evicted by client {}", visible(found->second.client),
               visible(asked.token.client));
  return control::Evicted{request.session};
}

control::Message ControlService::list_sessions(const PendingRequest& asked,
                                               const control::ListSessions& request) {
  if (auto refused = refuse_below(Role::admin, asked)) return *std::move(refused);
  control::SessionList list;
  for (auto at = seated_.upper_bound(request.after); at != seated_.end(); ++at) {
    if (!opens(asked.token, scene_name(at->second))) continue;
    if (list.sessions.size() == control::kMaxSessionEntries) {
      list.more = true;
      break;
    }
    const ListedSession& seated = at->second;
    list.sessions.push_back({at->first, seated.client, scene_name(seated), seated.role});
  }
  return list;
}

void ControlService::reload(PendingRequest asked, const control::ReloadScene& request) {
  const auto scene = scene_for(asked, request.scene, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  if (auto refused = refuse_hasty(asked)) return asked.answer(*std::move(refused));
  spdlog::info("scene {} is reloaded by client {} (token {})", request.scene,
               visible(asked.token.client), asked.token.id);
  asked.peer.waits = true;
  reload_(std::get<std::size_t>(scene),
          [this, name = request.scene,
           answer = std::move(asked.answer)](std::optional<Refused> refused) {
            if (!refused) return answer(control::SceneReloaded{name});
            if (refused->code == RefusalCode::too_many) ++counters_.too_many;
            answer(*std::move(refused));
          });
}

/// Changes what hands feel in a scene.
void ControlService::change(PendingRequest asked, const std::string& name, LiveChange change) {
  const auto scene = scene_for(asked, name, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  if (auto refused = refuse_hasty(asked)) return asked.answer(*std::move(refused));
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

/// Changes a session in a scene that the token of an admin opens.
void ControlService::change_session(PendingRequest asked, std::uint64_t session,
                                    LiveChange wanted) {
  if (auto refused = refuse_below(Role::admin, asked)) return asked.answer(*std::move(refused));
  const auto found = seated_.find(session);
  if (found == seated_.end() || !opens(asked.token, scene_name(found->second)))
    return asked.answer(unknown_session(session));
  change(std::move(asked), scene_name(found->second), std::move(wanted));
}

/// Asks the scene's thread, which alone knows the answer.
void ControlService::ask_scene(PendingRequest asked, const std::string& name,
                               control::Message request) {
  const auto scene = scene_for(asked, name, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  hosts_[std::get<std::size_t>(scene)]->ask(std::move(request), 0, {}, io_,
                                            std::move(asked.answer));
}

void ControlService::write_flight(PendingRequest asked, const control::WriteFlightRecord& request) {
  const auto scene = scene_for(asked, request.scene, Role::admin);
  if (const auto* refused = std::get_if<Refused>(&scene)) return asked.answer(*refused);
  if (!write_flight_) return asked.answer(no_flight_recorder());
  if (auto refused = refuse_hasty(asked)) return asked.answer(*std::move(refused));
  spdlog::info("scene {}: client {} (token {}) asks for a flight record", visible(request.scene),
               visible(asked.token.client), asked.token.id);
  asked.peer.waits = true;
  write_flight_(
      std::get<std::size_t>(scene), [name = request.scene, answer = std::move(asked.answer)](
                                        std::variant<std::string, Refused> outcome) {
        if (auto* refused = std::get_if<Refused>(&outcome)) return answer(std::move(*refused));
        answer(control::FlightRecordWritten{name, std::move(std::get<std::string>(outcome))});
      });
}

void ControlService::count(PendingRequest asked, const control::GetCounters& request) {
  if (!request.scene.empty()) return ask_scene(std::move(asked), request.scene, request);
  if (auto refused = refuse_below(Role::admin, asked)) return asked.answer(*std::move(refused));
  const ControlCounters connections = connections_ ? connections_() : ControlCounters{};
  control::Counters named;
  for (const auto& [name, value] : named_counters(connections, counters_))
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
