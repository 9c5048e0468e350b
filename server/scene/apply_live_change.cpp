// Live changes of a scene and its sessions. scene_host.cpp calls them in the scene's thread.

#include "server/scene/apply_live_change.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <stdexcept>

#include "core/scene/mechanism.hpp"
#include "core/scene/validation.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/session/grant.hpp"
#include "protocol/session/lead_share.hpp"
#include "protocol/session/material_fields.hpp"
#include "server/scene/parameter_changes.hpp"
#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

std::string vector_text(const Vec3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }

}  // namespace

std::size_t object_index(const Scene& scene, const std::string& name) {
  const std::vector<Object>& objects = scene.objects();
  const auto found = std::ranges::find(objects, name, &Object::name);
  if (found != objects.end()) return static_cast<std::size_t>(found - objects.begin());
  constexpr std::size_t kMostNames = 20;
  std::string names;
  for (std::size_t i = 0; i < std::min(objects.size(), kMostNames); ++i)
    names += (names.empty() ? "" : ", ") + objects[i].name;
  if (objects.size() > kMostNames) names += ", ...";
  throw std::invalid_argument("object: there is no object '" + name + "' in scene '" +
                              scene.name() + "'; name one of: " + names);
}

Changed changed(const Scene& scene, const MaterialChange& change) {
  const std::size_t index = object_index(scene, change.object);
  Material material = scene.objects()[index].material;
  std::string what;
  for (const MaterialField& field : kMaterialFields) {
    const std::optional<double>& wanted = change.*field.wanted;
    if (!wanted) continue;
    what += fmt::format("{}{} {} -> {}", what.empty() ? "" : ", ", field.name,
                        material.*field.value, *wanted);
    if (!field.unit.empty()) what += fmt::format(" [{}]", field.unit);
    material.*field.value = *wanted;
  }
  if (what.empty())
    throw std::invalid_argument("object '" + change.object +
                                "': no field of its material is given; give stiffness, damping, "
                                "static_friction, dynamic_friction or viscous_friction");
  Scene next = scene;
  next.set_material(index, material);
  return {"object '" + change.object + "': " + what,
          std::make_shared<const Scene>(std::move(next))};
}

/// Tries a change, with an operator for each kind.
struct SceneSessions::Change {
  SceneSessions& sessions;
  Nanoseconds now;

  /// The message for the log; empty without a log. Made before the change, because it may throw.
  std::vector<std::uint8_t> logged(const control::Message& message) const {
    return sessions.log_.payload(message);
  }
  void log(EventKind kind, Bytes what, std::uint32_t hand = 0) const noexcept {
    sessions.log_.put({.kind = kind, .hand = hand, .time = now, .payload = what});
  }

  ChangeOutcome operator()(const MaterialChange& change) {
    Changed made = changed(*sessions.scene_, change);
    const std::size_t object = object_index(*made.scene, change.object);
    std::vector<const ToolView*> views(sessions.slots_.size());
    for (std::size_t i = 0; i < views.size(); ++i)
      views[i] = made.scene->view(sessions.slots_[i]->tool);
    const auto event = logged(control::SetMaterial{made.scene->name(), change});
    // From here on nothing throws.
    for (std::size_t i = 0; i < views.size(); ++i)
      sessions.slots_[i]->session.adopt(*views[i], object);
    if (sessions.world_ != nullptr) sessions.world_->adopt(*made.scene);
    sessions.scene_ = made.scene.get();
    ++sessions.live_changes_;
    log(EventKind::change, event);
    return made;
  }
  ChangeOutcome operator()(const GravityChange& change) {
    if (sessions.world_ == nullptr)
      throw std::invalid_argument("gravity: nothing moves in scene '" + sessions.scene_->name() +
                                  "'; it acts on bodies only");
    if (const auto violation = feltwire::check(MechanismOptions{.gravity = change.gravity}))
      refuse("scene '" + sessions.scene_->name() + "'", *violation);
    Changed made{"gravity " + vector_text(sessions.world_->gravity()) + " -> " +
                     vector_text(change.gravity) + " [m/s^2]",
                 nullptr};
    const auto event = logged(control::SetGravity{sessions.scene_->name(), change.gravity});
    sessions.world_->set_gravity(change.gravity);
    for (const auto& slot : sessions.slots_) slot->session.weigh_anew();
    ++sessions.live_changes_;
    log(EventKind::change, event);
    return made;
  }
  ChangeOutcome operator()(const ParameterChange& change) {
    SessionSlot** slot = sessions.by_id_.find(change.session);
    if (slot == nullptr) return unknown_session(change.session);
    Session& session = (*slot)->session;
    const SessionParameters before = session.parameters();
    const SessionParameters wished = (*slot)->waits_for_client() && !(*slot)->asked->returns
                                         ? (*slot)->asked->parameters
                                         : before;
    const LawChoice law = law_of(change.parameters);
    const bool of_client =
        before.side == BoundingSide::client && (law != law_of(before) || law != law_of(wished));
    // The part of the change that the server makes itself.
    const SessionParameters here =
        of_client ? with_law(change.parameters, law_of(before)) : change.parameters;
    if (auto wrong = forbidden_change(before, here))
      return Refused{RefusalCode::bad_parameters, *std::move(wrong)};
    std::optional<AskedChange> asked;
    std::string what = changes(before, change.parameters);
    if (of_client) {
      const bool takes = (*slot)->takes.laws != LawsTaken::none;
      if (auto no = refuses_law(before, law, takes ? LawsTaken::any : LawsTaken::none))
        return Refused{RefusalCode::not_supported, *std::move(no)};
      asked = next_for(**slot, ClientChange{.law = law, .link = {}});
      asked->parameters = change.parameters;
      what += "; its client is asked for the law";
    }
    Changed made{fmt::format("session {} ({}): {}", (*slot)->number, session.client(), what),
                 nullptr};
    const auto event = logged(control::SetParameters{(*slot)->number, change.parameters});
    if (here != before) session.set_parameters(here);
    if (asked) (*slot)->asked = std::move(asked);
    log(EventKind::parameters, event, (*slot)->number);
    return made;
  }
  ChangeOutcome operator()(const LinkChange& change) {
    SessionSlot** slot = sessions.by_id_.find(change.session);
    if (slot == nullptr) return unknown_session(change.session);
    if (auto no = wrong(change.link)) return Refused{RefusalCode::bad_parameters, *std::move(no)};
    if (!(*slot)->takes.link)
      return Refused{RefusalCode::not_supported,
                     "its client has no emulated link to change; start it with --link, say "
                     "--link delay=0, and with --changes safe"};
    AskedChange asked = next_for(**slot, ClientChange{.law = {}, .link = change.link});
    Changed made{fmt::format("session {} ({}): its client is asked for: {}", (*slot)->number,
                             (*slot)->session.client(), text(change.link)),
                 nullptr};
    const auto event = logged(control::SetLink{(*slot)->number, change.link});
    (*slot)->asked = std::move(asked);
    log(EventKind::change, event, (*slot)->number);
    return made;
  }

  ChangeOutcome operator()(const LeadChange& change) {
    SessionSlot** slot = sessions.by_id_.find(change.session);
    if (slot == nullptr) return unknown_session(change.session);
    if (const auto wrong = wrong_lead_share(change.share))
      throw std::invalid_argument("lead share: " + *wrong);
    if (sessions.seats_.empty())
      return Refused{RefusalCode::not_supported,
                     "lead share: scene '" + sessions.scene_->name() +
                         "' has no seat for a robot; give it one with remote (docs/scenes.md)"};
    if (!covers((*slot)->role, Role::operator_))
      return Refused{RefusalCode::not_supported,
                     "lead share: session " + std::to_string((*slot)->number) + " joined as " +
                         std::string(name((*slot)->role)) + " and leads no robot; name a hand"};
    Changed made{fmt::format("session {} ({}): lead share {} -> {}", (*slot)->number,
                             (*slot)->session.client(), (*slot)->lead_share, change.share),
                 nullptr};
    const auto event = logged(control::SetLead{(*slot)->number, change.share});
    (*slot)->lead_share = change.share;
    log(EventKind::change, event, (*slot)->number);
    return made;
  }

  /// The next change for the client. If the client has not answered the previous change, it
  /// includes each part of that change that the new change does not replace.
  static AskedChange next_for(const SessionSlot& slot, ClientChange change) {
    AskedChange next{.change = change, .parameters = slot.session.parameters(), .what = {}};
    const LawChoice before = law_of(next.parameters);
    if (slot.waits_for_client()) {
      const AskedChange& waits = *slot.asked;
      if (!waits.returns) next.parameters = waits.parameters;
      next.unheard_law = waits.unheard_law || waits.returns || waits.change.law;
      if (!change.law) next.change.law = waits.change.law;
      if (!change.link) next.change.link = waits.change.link;
    }
    if (next.change.law) next.what = difference(before, *next.change.law);
    if (next.change.link) next.what += (next.what.empty() ? "" : ", ") + text(*next.change.link);
    next.change.number = number_after(slot.asked ? slot.asked->change.number : std::uint8_t{0});
    return next;
  }
};

ChangeOutcome SceneSessions::change(const LiveChange& change, Nanoseconds now) {
  try {
    return std::visit(Change{*this, now}, change);
  } catch (const std::invalid_argument& error) {
    return Refused{RefusalCode::bad_parameters, error.what()};
  }
}

std::optional<Vec3> SceneSessions::gravity() const {
  if (world_ == nullptr) return std::nullopt;
  return world_->gravity();
}

}  // namespace feltwire
