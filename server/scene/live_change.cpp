// Live changes of a scene and its sessions. Where a scene's thread has its turn: scene_host.cpp.

#include "server/scene/live_change.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "core/scene/mechanism.hpp"
#include "core/scene/validation.hpp"
#include "protocol/session/grant.hpp"
#include "server/scene/parameter_changes.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

/// A field of a material that may be changed.
struct MaterialField {
  const char* name;
  const char* unit;
  double Material::*value;
  std::optional<double> MaterialChange::*wanted;
};
constexpr std::array<MaterialField, 5> kMaterialFields = {{
    {"stiffness", " [N/m]", &Material::stiffness, &MaterialChange::stiffness},
    {"damping", " [N s/m]", &Material::damping, &MaterialChange::damping},
    {"static_friction", "", &Material::static_friction, &MaterialChange::static_friction},
    {"dynamic_friction", "", &Material::dynamic_friction, &MaterialChange::dynamic_friction},
    {"viscous_friction", " [N s/m]", &Material::viscous_friction,
     &MaterialChange::viscous_friction},
}};

std::string text(const Vec3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }

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
    what += fmt::format("{}{} {} -> {}{}", what.empty() ? "" : ", ", field.name,
                        material.*field.value, *wanted, field.unit);
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

/// Tries a change of a kind.
struct SceneSessions::Change {
  SceneSessions& sessions;
  Nanoseconds now;

  /// For the log; empty where there is none. Made before the change: it may throw.
  std::vector<std::uint8_t> logged(const control::Message& message) const {
    return sessions.log_ == nullptr ? std::vector<std::uint8_t>{} : body(message);
  }
  void log(EventKind kind, Bytes what, std::uint32_t hand = 0) const noexcept {
    sessions.log({.kind = kind, .hand = hand, .time = now, .payload = what});
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
    log(EventKind::change, event);
    return made;
  }
  ChangeOutcome operator()(const GravityChange& change) {
    if (sessions.world_ == nullptr)
      throw std::invalid_argument("gravity: nothing moves in scene '" + sessions.scene_->name() +
                                  "'; it acts on bodies only");
    if (const auto violation = feltwire::check(MechanismOptions{.gravity = change.gravity}))
      refuse("scene '" + sessions.scene_->name() + "'", *violation);
    Changed made{
        "gravity " + text(sessions.world_->gravity()) + " -> " + text(change.gravity) + " [m/s^2]",
        nullptr};
    const auto event = logged(control::SetGravity{sessions.scene_->name(), change.gravity});
    sessions.world_->set_gravity(change.gravity);
    log(EventKind::change, event);
    return made;
  }
  ChangeOutcome operator()(const ParameterChange& change) {
    SessionSlot** slot = sessions.by_id_.find(change.session);
    if (slot == nullptr) return unknown_session(change.session);
    Session& session = (*slot)->session;
    const SessionParameters before = session.parameters();
    if (auto wrong = forbidden_change(before, change.parameters))
      return Refused{RefusalCode::bad_parameters, *std::move(wrong)};
    Changed made{fmt::format("session {} ({}): {}", (*slot)->number, session.client(),
                             changes(before, change.parameters)),
                 nullptr};
    const auto event = logged(control::SetParameters{(*slot)->number, change.parameters});
    session.set_parameters(change.parameters);
    log(EventKind::parameters, event, (*slot)->number);
    return made;
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
