#include "server/scene/admin_changes.hpp"

#include <spdlog/fmt/fmt.h>

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/scene/mechanism.hpp"
#include "core/scene/validation.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/session/lead_share.hpp"
#include "protocol/session/role.hpp"
#include "server/scene/client_changes.hpp"
#include "server/scene/parameter_changes.hpp"
#include "server/scene/prefetched_surfaces.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

std::string vector_text(const Vec3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }

/// Describes a change of one session as "session 2 (anna): `what`". The scene stays the same.
Changed changed_session(const SessionSlot& slot, const std::string& what) {
  return {fmt::format("session {} ({}): {}", slot.number, slot.session.client(), what), nullptr};
}

}  // namespace

ChangeOutcome AdminChanges::change(const LiveChange& change, Nanoseconds now) {
  try {
    return std::visit([&](const auto& wanted) { return make(wanted, now); }, change);
  } catch (const std::invalid_argument& error) {
    return Refused{RefusalCode::bad_parameters, error.what()};
  }
}

ChangeOutcome AdminChanges::make(const MaterialChange& change, Nanoseconds now) {
  Changed made = changed(*served_.scene, change);
  const std::size_t object = object_index(*made.scene, change.object);
  const SessionSlots& slots = table_.slots();
  std::vector<const ToolView*> views(slots.size());
  for (std::size_t i = 0; i < views.size(); ++i) views[i] = made.scene->view(slots[i]->tool);
  const auto event = log_.payload(control::SetMaterial{made.scene->name(), change});
  // The calls below do not throw, so the change is made completely.
  for (std::size_t i = 0; i < views.size(); ++i) slots[i]->session.adopt(*views[i], object);
  if (World* const world = clock_.world()) world->adopt(*made.scene);
  served_.scene = made.scene.get();
  ++served_.live_changes;
  log(EventKind::change, now, event);
  return made;
}

ChangeOutcome AdminChanges::make(const GravityChange& change, Nanoseconds now) {
  World* const world = clock_.world();
  if (world == nullptr)
    throw std::invalid_argument("gravity: nothing moves in scene '" + served_.scene->name() +
                                "'; it acts on bodies only");
  if (const auto violation = check(MechanismOptions{.gravity = change.gravity}))
    refuse("scene '" + served_.scene->name() + "'", *violation);
  Changed made{"gravity " + vector_text(world->gravity()) + " -> " + vector_text(change.gravity) +
                   " [m/s^2]",
               nullptr};
  const auto event = log_.payload(control::SetGravity{served_.scene->name(), change.gravity});
  world->set_gravity(change.gravity);
  for (const auto& slot : table_.slots()) slot->session.weigh_anew();
  ++served_.live_changes;
  log(EventKind::change, now, event);
  return made;
}

ChangeOutcome AdminChanges::make(const ParameterChange& change, Nanoseconds now) {
  SessionSlot* const slot = table_.find(change.session);
  if (slot == nullptr) return unknown_session(change.session);
  Session& session = slot->session;
  const SessionParameters before = session.parameters();
  const SessionParameters wished =
      slot->waits_for_client() && !slot->asked->returns ? slot->asked->parameters : before;
  const LawChoice law = law_of(change.parameters);
  const bool of_client =
      before.side == BoundingSide::client && (law != law_of(before) || law != law_of(wished));
  // The parameters that the server sets now. If the bounding law runs at the client, they contain
  // the present law, because the client has not taken the new law yet.
  const SessionParameters here =
      of_client ? with_law(change.parameters, law_of(before)) : change.parameters;
  if (auto wrong = forbidden_change(before, here))
    return Refused{RefusalCode::bad_parameters, *std::move(wrong)};
  std::optional<AskedChange> asked;
  std::string what = changes(before, change.parameters);
  if (of_client) {
    const bool takes = slot->takes.laws != LawsTaken::none;
    if (auto no = refuses_law(before, law, takes ? LawsTaken::any : LawsTaken::none))
      return Refused{RefusalCode::not_supported, *std::move(no)};
    asked = next_change(*slot, ClientChange{.law = law, .link = {}});
    asked->parameters = change.parameters;
    what += "; its client is asked for the law";
  }
  Changed made = changed_session(*slot, what);
  const auto event = log_.payload(control::SetParameters{slot->number, change.parameters});
  if (here != before) session.set_parameters(here);
  if (asked) slot->asked = std::move(asked);
  log(EventKind::parameters, now, event, slot->number);
  return made;
}

ChangeOutcome AdminChanges::make(const LinkChange& change, Nanoseconds now) {
  SessionSlot* const slot = table_.find(change.session);
  if (slot == nullptr) return unknown_session(change.session);
  if (auto no = wrong(change.link)) return Refused{RefusalCode::bad_parameters, *std::move(no)};
  if (!slot->takes.link)
    return Refused{RefusalCode::not_supported,
                   "its client has no emulated link to change; start it with --link, say "
                   "--link delay=0, and with --changes safe"};
  AskedChange asked = next_change(*slot, ClientChange{.law = {}, .link = change.link});
  Changed made = changed_session(*slot, "its client is asked for: " + text(change.link));
  const auto event = log_.payload(control::SetLink{slot->number, change.link});
  slot->asked = std::move(asked);
  log(EventKind::change, now, event, slot->number);
  return made;
}

ChangeOutcome AdminChanges::make(const LeadChange& change, Nanoseconds now) {
  SessionSlot* const slot = table_.find(change.session);
  if (slot == nullptr) return unknown_session(change.session);
  if (const auto wrong = wrong_lead_share(change.share))
    throw std::invalid_argument("lead share: " + *wrong);
  if (seats_.empty())
    return Refused{RefusalCode::not_supported,
                   "lead share: scene '" + served_.scene->name() +
                       "' has no seat for a robot; give it one with remote (docs/scenes.md)"};
  if (!covers(slot->role, Role::operator_))
    return Refused{RefusalCode::not_supported,
                   "lead share: session " + std::to_string(slot->number) + " joined as " +
                       std::string(name(slot->role)) + " and leads no robot; name a hand"};
  Changed made =
      changed_session(*slot, fmt::format("lead share {} -> {}", slot->lead_share, change.share));
  const auto event = log_.payload(control::SetLead{slot->number, change.share});
  slot->lead_share = change.share;
  log(EventKind::change, now, event, slot->number);
  return made;
}

control::Message AdminChanges::take_surfaces(const control::TakeSurfaces& request,
                                             Nanoseconds now) {
  SessionSlot* const slot = table_.find(request.session);
  if (slot == nullptr) return unknown_session(request.session);
  const ToolView* view = served_.scene->view(slot->tool);
  if (view == nullptr ||
      request.version != prefetched_version(*view, served_.version, served_.live_changes))
    return other_version(request.version, "surfaces");
  control::TakeSurfaces logged = request;
  logged.session = slot->number;
  const std::vector<std::uint8_t> event = log_.payload(logged);
  if (auto wrong = slot->session.take_surfaces(request.version, request.objects))
    return Refused{RefusalCode::bad_parameters, *std::move(wrong)};
  log(EventKind::parameters, now, event, slot->number);
  return control::SurfacesTaken{request.session};
}

}  // namespace feltwire
